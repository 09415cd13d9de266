#include "steps.h"
#include <math.h>

/* How far a communication step may be from a whole number of sample periods, in periods. Importers that add up
   their time lose some 1e-4 of a period in ten million steps; a step that is meant to be another is farther off. */
#define STEP_TOLERANCE 1e-3

/* How far a communication point may be from the time of this instance, in periods: it is the same sample. */
#define POINT_TOLERANCE 0.5

#define MOST_SAMPLES 9e15 /* that a double can count */

static status check_step(instance *self, double point, double size) {
    const double time = instance_time(self), periods = size / MODEL_PERIOD;
    if (!(fabs(point - time) < POINT_TOLERANCE * MODEL_PERIOD)) {
        return instance_refuse(self, "the communication point %.10g s is not the time of this instance, %.10g s",
                               point, time);
    }
    if (!(periods > POINT_TOLERANCE && periods < MOST_SAMPLES) ||
        fabs(periods - (double)(uint64_t)(periods + 0.5)) > STEP_TOLERANCE) {
        return instance_refuse(self, "a step of %.10g s is not a whole multiple of the sample period of %.10g s",
                               size, (double)MODEL_PERIOD);
    }
    if (time + size > self->now.stop + POINT_TOLERANCE * MODEL_PERIOD) {
        return instance_refuse(self, "a step from %.10g s by %.10g s passes the stop time of %.10g s", time, size,
                               self->now.stop);
    }
    return STATUS_OK;
}

/* Finds outputs that a step has lost. Numbers that were not finite before it do not count: observers start with
   what they do not know yet as nan. Nor do others than outputs: a law whose sensor fails gets over its nan. */
static status check_outputs(instance *self, const model_numbers *before) {
    status worst = STATUS_OK;
    for (size_t i = MODEL_FIRST_STATE; i < MODEL_VARIABLES; i++) {
        const model_variable *variable = &model_variables[i];
        const bool lost = variable->kind == VARIABLE_OUTPUT && !isfinite(instance_number(&self->now.numbers, variable)) &&
                          isfinite(instance_number(before, variable));
        if (lost && variable->vital) {
            return instance_refuse(self, "%s diverged: it is no longer finite at %.10g s", variable->name,
                                   instance_time(self));
        }
        if (lost) {
            worst = instance_warn(self, "%s is not finite at %.10g s", variable->name, instance_time(self));
        }
    }
    return worst;
}

status steps_take(instance *self, double point, double size) {
    const model_numbers before = self->now.numbers;
    if (check_step(self, point, size) != STATUS_OK) {
        return STATUS_ERROR;
    }
    const uint64_t samples = (uint64_t)(size / MODEL_PERIOD + 0.5);
    for (uint64_t k = 0; k < samples; k++) {
        model_step(&self->now.numbers);
    }
    self->now.samples += samples;
    self->now.given = 0;
    self->ahead_known = false;
    return check_outputs(self, &before);
}
