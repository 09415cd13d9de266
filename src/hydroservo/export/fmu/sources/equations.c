#include "equations.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Passes the time on to the model, which counts from the start. */
static void set_instant(instance *self, double until) {
    model_set_instant(&self->now.numbers, self->now.time - self->now.start, until);
    self->ahead_known = false;
}

static double until_now(const instance *self) {
    return self->now.phase == CONTINUOUS ? self->now.jump : (double)INFINITY;
}

static status check_array(instance *self, const double values[], size_t count) {
    if (values == NULL) {
        return instance_refuse(self, "a null pointer stands for an array of %u numbers", MODEL_STATES);
    }
    if (count != MODEL_STATES) {
        return instance_refuse(self, "%lu is not the number of continuous states, %u", (unsigned long)count,
                               MODEL_STATES);
    }
    return STATUS_OK;
}

status equations_set_time(instance *self, double time) {
    if (!isfinite(time)) {
        return instance_refuse(self, "a time of %g s is not a finite number", time);
    }
    self->now.time = time;
    set_instant(self, until_now(self));
    return STATUS_OK;
}

status equations_enter_events(instance *self) {
    self->now.phase = EVENTS;
    set_instant(self, until_now(self));
    return STATUS_OK;
}

/* The first time of an importer at which as much as this has passed since the start: the sum may be rounded
   down, and an event at that time would come too soon, again and again. */
static double time_after(const instance *self, double passed) {
    const double time = self->now.start + passed;
    return time - self->now.start < passed ? time + DBL_EPSILON * fabs(time) : time;
}

status equations_update(instance *self, double *next) {
    self->now.jump = model_jump(instance_numbers(self));
    *next = time_after(self, self->now.jump);
    return STATUS_OK;
}

status equations_enter_continuous(instance *self) {
    self->now.phase = CONTINUOUS;
    set_instant(self, until_now(self));
    return STATUS_OK;
}

status equations_set_states(instance *self, const double values[], size_t count) {
    if (check_array(self, values, count) != STATUS_OK) {
        return STATUS_ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (isnan(values[i])) {
            return instance_discard(self, "the states stay as they are: %s is not a number",
                                    model_variables[model_states[i]].name);
        }
    }
    for (size_t i = 0; i < count; i++) {
        memcpy((char *)&self->now.numbers + model_variables[model_states[i]].place, &values[i],
               sizeof values[i]);
    }
    self->ahead_known = false;
    return STATUS_OK;
}

status equations_get_states(instance *self, double values[], size_t count) {
    const status checked = check_array(self, values, count);
    return checked == STATUS_OK ? instance_get(self, model_states, count, values) : checked;
}

status equations_get_rates(instance *self, double values[], size_t count) {
    if (check_array(self, values, count) != STATUS_OK ||
        instance_get(self, model_rates, count, values) != STATUS_OK) {
        return STATUS_ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            return instance_discard(self, "%s is not finite at %.10g s", model_variables[model_rates[i]].name,
                                    instance_time(self));
        }
    }
    return STATUS_OK;
}

status equations_get_nominals(instance *self, double values[], size_t count) {
    const status checked = check_array(self, values, count);
    if (checked == STATUS_OK) {
        memcpy(values, model_nominals, sizeof model_nominals);
    }
    return checked;
}
