/* Samples of the model, which communication steps or the ticks of a clock take. */
#ifndef SAMPLES_H
#define SAMPLES_H

#include "instance.h"

#define samples_take FMU_NAME(samples_take)
#define samples_check_point FMU_NAME(samples_check_point)

/* Takes samples with the inputs held, and reports outputs that are no longer finite after them. */
status samples_take(instance *self, uint64_t count);

/* Refuses a communication step that begins at another time than the instance's, or passes the stop time. */
status samples_check_point(instance *self, double point, double size, double tolerance);

#endif
