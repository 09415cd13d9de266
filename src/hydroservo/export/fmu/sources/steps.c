/* Communication steps that take samples. */
#include "steps.h"
#include "samples.h"
#include <math.h>

/* How far a communication step may be from a whole number of sample periods, in periods. Importers that add
   up their time lose some 1e-4 of a period in ten million steps; a step that is meant to be another is
   farther off. */
#define STEP_TOLERANCE 1e-3

/* How far a communication point may be from the time of this instance, in periods: it is the same sample. */
#define POINT_TOLERANCE 0.5

#define MOST_SAMPLES 9e15 /* that a double can count */

static status check_size(instance *self, double size) {
    const double periods = size / MODEL_PERIOD;
    if (!(periods > POINT_TOLERANCE && periods < MOST_SAMPLES) ||
        fabs(periods - (double)(uint64_t)(periods + 0.5)) > STEP_TOLERANCE) {
        return instance_refuse(self,
                               "a step of %.10g s is not a whole multiple of the sample period of %.10g s",
                               size, (double)MODEL_PERIOD);
    }
    return STATUS_OK;
}

status steps_take(instance *self, double point, double size) {
    if (samples_check_point(self, point, size, POINT_TOLERANCE * MODEL_PERIOD) != STATUS_OK ||
        check_size(self, size) != STATUS_OK) {
        return STATUS_ERROR;
    }
    return samples_take(self, (uint64_t)(size / MODEL_PERIOD + 0.5));
}
