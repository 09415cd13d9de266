/* Communication steps that let time pass, and ticks that take samples. */
#include "ticks.h"
#include "samples.h"
#include "steps.h"
#include <math.h>

/* [s] how far a communication point or a tick may be from its instant. Importers round what they add up. */
#define TOLERANCE (1e-3 * MODEL_PERIOD)

/* Warns where the clock was due before a time and has not ticked. */
static status check_missed(instance *self, double time) {
    const double due = self->now.due;
    if (!(due < time - TOLERANCE)) {
        return STATUS_OK;
    }
    self->now.due += MODEL_PERIOD * ceil((time - TOLERANCE - due) / MODEL_PERIOD);
    return instance_warn(self, "the clock %s was due at %.10g s and did not tick: no sample was taken",
                         MODEL_CLOCK_NAME, due);
}

status steps_take(instance *self, double point, double size) {
    if (samples_check_point(self, point, size, TOLERANCE) != STATUS_OK) {
        return STATUS_ERROR;
    }
    if (!(size > 0.0) || !isfinite(point + size)) {
        return instance_refuse(self, "a step of %.10g s is not positive and finite", size);
    }
    self->now.time = point + size;
    return check_missed(self, self->now.time);
}

void ticks_enter_events(instance *self) {
    self->now.phase = EVENTS;
}

void ticks_leave_events(instance *self) {
    self->now.phase = STEPPING;
}

status ticks_expect_clock(instance *self, const unsigned references[], size_t count, const void *values) {
    if (count > 0 && (references == NULL || values == NULL)) {
        return instance_refuse(self, "a null pointer stands for %lu clocks or what is asked of them",
                               (unsigned long)count);
    }
    for (size_t i = 0; i < count; i++) {
        if (references[i] != MODEL_CLOCK) {
            return instance_refuse(self, "no clock has the value reference %u", references[i]);
        }
    }
    return STATUS_OK;
}

bool ticks_active(const instance *self) {
    return self->now.phase == TICKING;
}

status ticks_set(instance *self, bool active) {
    const double due = self->now.due;
    if (active && !(fabs(self->now.time - due) < TOLERANCE)) {
        return instance_refuse(self, "the clock %s is due at %.10g s and cannot tick at %.10g s",
                               MODEL_CLOCK_NAME, due, self->now.time);
    }
    self->now.phase = active ? TICKING : EVENTS;
    return STATUS_OK;
}

status ticks_update(instance *self) {
    if (!ticks_active(self)) {
        return STATUS_OK;
    }
    self->now.phase = EVENTS;
    self->now.due = self->now.time + MODEL_PERIOD;
    return samples_take(self, 1);
}
