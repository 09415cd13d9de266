/* A clock: while it is active, in the event mode, the model answers its inputs; the end of the tick takes the
   sample. */
#ifndef TICKS_H
#define TICKS_H

#include "instance.h"

#define ticks_enter_events FMU_NAME(ticks_enter_events)
#define ticks_leave_events FMU_NAME(ticks_leave_events)
#define ticks_expect_clock FMU_NAME(ticks_expect_clock)
#define ticks_active FMU_NAME(ticks_active)
#define ticks_set FMU_NAME(ticks_set)
#define ticks_update FMU_NAME(ticks_update)

void ticks_enter_events(instance *self);
void ticks_leave_events(instance *self);

/* Refuses value references that are not those of the clock, and null pointers. */
status ticks_expect_clock(instance *self, const unsigned references[], size_t count, const void *values);

bool ticks_active(const instance *self);

/* Activates the clock where it is due, or deactivates it as if nothing had happened. */
status ticks_set(instance *self, bool active);

/* Takes the sample of a clock that is active. */
status ticks_update(instance *self);

#endif
