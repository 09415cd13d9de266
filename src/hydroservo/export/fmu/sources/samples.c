#include "samples.h"
#include <math.h>

/* Finds outputs that are no longer finite after samples. Numbers that were not finite before do not count:
   observers start with nan for what they do not know yet. Nor do states that are no outputs: a law whose
   sensor fails recovers from its nan. */
static status check_outputs(instance *self, const model_numbers *before) {
    status worst = STATUS_OK;
    for (size_t i = MODEL_FIRST_STATE; i < MODEL_VARIABLES; i++) {
        const model_variable *variable = &model_variables[i];
        const bool lost = variable->kind == VARIABLE_OUTPUT &&
                          !isfinite(instance_number(&self->now.numbers, variable)) &&
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

status samples_take(instance *self, uint64_t count) {
    const model_numbers before = self->now.numbers;
    for (uint64_t k = 0; k < count; k++) {
        model_step(&self->now.numbers);
    }
    self->now.samples += count;
    self->now.given = 0;
    self->ahead_known = false;
    return check_outputs(self, &before);
}

status samples_check_point(instance *self, double point, double size, double tolerance) {
    const double time = instance_time(self);
    if (!(fabs(point - time) < tolerance)) {
        return instance_refuse(
            self, "the communication point %.10g s is not the time of this instance, %.10g s", point, time);
    }
    if (time + size > self->now.stop + tolerance) {
        return instance_refuse(self, "a step from %.10g s by %.10g s passes the stop time of %.10g s", time,
                               size, self->now.stop);
    }
    return STATUS_OK;
}
