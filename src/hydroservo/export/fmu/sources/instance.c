#include "instance.h"
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How far a communication step may be from a whole number of sample periods, in periods. Importers that add up
   their time lose some 1e-4 of a period in ten million steps; a step that is meant to be another is farther off. */
#define STEP_TOLERANCE 1e-3

/* How far a communication point may be from the time of this instance, in periods: it is the same sample. */
#define POINT_TOLERANCE 0.5

#define MOST_SAMPLES 9e15 /* that a double can count */

static const char *const categories_of[] = {
    [STATUS_WARNING] = "logStatusWarning",
    [STATUS_DISCARD] = "logStatusDiscard",
    [STATUS_ERROR] = "logStatusError",
};

/* --- messages --- */

static void report(const instance *self, status severity, const char *format, va_list arguments) {
    char message[400];
    if (self->wanted[severity]) {
        (void)vsnprintf(message, sizeof message, format, arguments);
        self->sink(self, severity, categories_of[severity], message);
    }
}

static status warn(instance *self, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    report(self, STATUS_WARNING, format, arguments);
    va_end(arguments);
    return STATUS_WARNING;
}

status instance_refuse(instance *self, const char *format, ...) {
    va_list arguments;
    self->now.phase = FAILED;
    va_start(arguments, format);
    report(self, STATUS_ERROR, format, arguments);
    va_end(arguments);
    return STATUS_ERROR;
}

status instance_discard(instance *self, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    report(self, STATUS_DISCARD, format, arguments);
    va_end(arguments);
    return STATUS_DISCARD;
}

/* The severity that a category is of; STATUS_OK, which has none, where it is not one of the model description. */
static status severity_of(const char *category) {
    for (status severity = STATUS_WARNING; category != NULL && severity <= STATUS_ERROR; severity++) {
        if (strcmp(category, categories_of[severity]) == 0) {
            return severity;
        }
    }
    return STATUS_OK;
}

status instance_log(instance *self, bool on, size_t count, const char *const categories[]) {
    bool wanted[STATUS_ERROR + 1] = {false};
    for (size_t i = 0; i < count; i++) {
        const status severity = categories == NULL ? STATUS_OK : severity_of(categories[i]);
        if (severity == STATUS_OK) {
            return warn(self, "a log category is not one of the model description: messages stay as they were");
        }
        wanted[severity] = true;
    }
    for (status severity = STATUS_WARNING; severity <= STATUS_ERROR; severity++) {
        /* Why a call failed is always said: no importer can find out otherwise. */
        self->wanted[severity] = severity >= STATUS_DISCARD || (on && (count == 0 || wanted[severity]));
    }
    return STATUS_OK;
}

static const char *phase_text(uint64_t in) {
    switch (in) {
    case INSTANTIATED:
        return "before the initialization mode";
    case INITIALIZATION:
        return "in the initialization mode";
    case STEPPING:
        return "after the initialization";
    case TERMINATED:
        return "after the termination";
    default:
        return "after an error, before a reset";
    }
}

status instance_expect(instance *self, unsigned phases, const char *call) {
    if ((self->now.phase & phases) == 0) {
        return instance_refuse(self, "%s must not be called %s", call, phase_text(self->now.phase));
    }
    return STATUS_OK;
}

status instance_lacks(instance *self, size_t count, const char *type) {
    return count == 0 ? STATUS_OK : instance_refuse(self, "no variable is of type %s", type);
}

/* --- numbers --- */

static double number(const model_numbers *numbers, const model_variable *variable) {
    double value;
    memcpy(&value, (const char *)numbers + variable->place, sizeof value);
    return value;
}

static double number_of_state(const model_state *state, const model_variable *variable) {
    double value;
    memcpy(&value, (const char *)state + (variable->place - offsetof(model_numbers, state)), sizeof value);
    return value;
}

static bool is_parameter(const model_variable *variable) {
    return variable->kind == VARIABLE_FIXED || variable->kind == VARIABLE_TUNABLE;
}

static status check_references(instance *self, const unsigned references[], size_t count, const double values[]) {
    if (count > 0 && (references == NULL || values == NULL)) {
        return instance_refuse(self, "a null pointer stands for %lu value references or values",
                               (unsigned long)count);
    }
    for (size_t i = 0; i < count; i++) {
        if (references[i] >= MODEL_VARIABLES) {
            return instance_refuse(self, "no variable has the value reference %u", references[i]);
        }
    }
    return STATUS_OK;
}

static status out_of_range(instance *self, const model_variable *variable, double value) {
    if (isfinite(variable->most)) {
        return instance_discard(self, "%s stays as it is and is not set to %.10g: it lies from %.10g to %.10g",
                                variable->name, value, variable->least, variable->most);
    }
    if (variable->least > 0.0 && variable->least < DBL_MIN) {
        return instance_discard(self, "%s stays as it is and is not set to %.10g: it must be above 0", variable->name,
                                value);
    }
    return instance_discard(self, "%s stays as it is and is not set to %.10g: it must be at least %.10g",
                            variable->name, value, variable->least);
}

static status check_value(instance *self, const model_variable *variable, double value) {
    if (variable->kind == VARIABLE_CONSTANT) {
        return instance_refuse(self, "%s cannot be set: it is constant", variable->name);
    }
    if (!is_parameter(variable) && variable->kind != VARIABLE_INPUT) {
        return instance_refuse(self, "%s cannot be set: the model computes it", variable->name);
    }
    if (variable->kind == VARIABLE_FIXED && self->now.phase == STEPPING) {
        return instance_refuse(self, "%s cannot be set after the initialization: it is read there alone",
                               variable->name);
    }
    if (is_parameter(variable) && !isfinite(value)) {
        return instance_discard(self, "%s stays as it is and is not set to %g: a parameter is a finite number",
                                variable->name, value);
    }
    if (is_parameter(variable) && !(value >= variable->least && value <= variable->most)) {
        return out_of_range(self, variable, value);
    }
    return STATUS_OK;
}

/* The numbers as an importer sees them: those of a controller follow its inputs at once. */
static const model_numbers *numbers_now(instance *self) {
    if (!MODEL_FEEDS_THROUGH || self->now.given == 0 || self->now.phase == INSTANTIATED) {
        return &self->now.numbers;
    }
    if (!self->ahead_known) {
        self->ahead = self->now.numbers;
        model_step(&self->ahead);
        self->ahead_known = true;
    }
    return &self->ahead;
}

status instance_get(instance *self, const unsigned references[], size_t count, double values[]) {
    if (check_references(self, references, count, values) != STATUS_OK) {
        return STATUS_ERROR;
    }
    const model_numbers *numbers = numbers_now(self);
    for (size_t i = 0; i < count; i++) {
        const model_variable *variable = &model_variables[references[i]];
        values[i] = variable->kind == VARIABLE_TIME ? instance_time(self) : number(numbers, variable);
    }
    return STATUS_OK;
}

status instance_set(instance *self, const unsigned references[], size_t count, const double values[]) {
    if (check_references(self, references, count, values) != STATUS_OK) {
        return STATUS_ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        const status checked = check_value(self, &model_variables[references[i]], values[i]);
        if (checked != STATUS_OK) {
            return checked;
        }
    }
    for (size_t i = 0; i < count; i++) {
        const model_variable *variable = &model_variables[references[i]];
        memcpy((char *)&self->now.numbers + variable->place, &values[i], sizeof values[i]);
        self->now.given |= variable->kind == VARIABLE_INPUT;
    }
    self->ahead_known = false;
    if (self->now.phase != STEPPING) {
        model_init(&self->now.numbers); /* so that outputs are always those of the parameters */
    }
    return STATUS_OK;
}

/* --- life --- */

void instance_reset(instance *self) {
    memset(&self->now, 0, sizeof self->now);
    self->ahead_known = false;
    memcpy(self->now.token, MODEL_TOKEN, sizeof MODEL_TOKEN);
    self->now.phase = INSTANTIATED;
    self->now.stop = INFINITY;
    model_defaults(&self->now.numbers);
    model_init(&self->now.numbers);
}

void instance_begin(instance *self, message_sink *sink) {
    self->sink = sink;
    instance_reset(self);
}

status instance_setup(instance *self, double start, bool stop_defined, double stop) {
    if (!isfinite(start)) {
        return instance_refuse(self, "a start time of %g s is not a finite number", start);
    }
    if (stop_defined && !(stop >= start)) {
        return instance_refuse(self, "the stop time of %.10g s comes before the start time of %.10g s", stop, start);
    }
    self->now.start = start;
    self->now.stop = stop_defined ? stop : INFINITY;
    return STATUS_OK;
}

status instance_enter_initialization(instance *self) {
    self->now.phase = INITIALIZATION;
    return STATUS_OK;
}

status instance_exit_initialization(instance *self) {
    for (size_t i = MODEL_FIRST_STATE; i < MODEL_VARIABLES; i++) {
        const model_variable *variable = &model_variables[i];
        if (variable->vital && !isfinite(number(&self->now.numbers, variable))) {
            return instance_refuse(self, "%s is not finite after the initialization", variable->name);
        }
    }
    self->now.phase = STEPPING;
    return STATUS_OK;
}

status instance_terminate(instance *self) {
    self->now.phase = TERMINATED;
    return STATUS_OK;
}

/* --- steps --- */

double instance_time(const instance *self) {
    return self->now.start + (double)self->now.samples * MODEL_PERIOD;
}

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
static status check_outputs(instance *self, const model_state *before) {
    status worst = STATUS_OK;
    for (size_t i = MODEL_FIRST_STATE; i < MODEL_VARIABLES; i++) {
        const model_variable *variable = &model_variables[i];
        const bool lost = variable->kind == VARIABLE_OUTPUT && !isfinite(number(&self->now.numbers, variable)) &&
                          isfinite(number_of_state(before, variable));
        if (lost && variable->vital) {
            return instance_refuse(self, "%s diverged: it is no longer finite at %.10g s", variable->name,
                                   instance_time(self));
        }
        if (lost) {
            worst = warn(self, "%s is not finite at %.10g s", variable->name, instance_time(self));
        }
    }
    return worst;
}

status instance_step(instance *self, double point, double size) {
    const model_state before = self->now.numbers.state;
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

/* --- saved states --- */

static bool is_ours(const void *saved) { /* which starts with the token */
    return memcmp(saved, MODEL_TOKEN, sizeof MODEL_TOKEN) == 0;
}

static status keep(instance *self, const void *state, void **saved) {
    if (*saved == NULL) {
        *saved = calloc(1, sizeof(snapshot));
    }
    if (*saved == NULL) {
        return instance_refuse(self, "there is no memory for a saved state");
    }
    memcpy(*saved, state, sizeof(snapshot));
    return STATUS_OK;
}

status instance_save(instance *self, void **saved) {
    if (saved == NULL) {
        return instance_refuse(self, "a null pointer stands for where the saved state goes");
    }
    return keep(self, &self->now, saved);
}

status instance_restore(instance *self, const void *saved) {
    if (saved == NULL || !is_ours(saved)) {
        return instance_refuse(self, "what is to be restored is no saved state of this FMU");
    }
    memcpy(&self->now, saved, sizeof self->now);
    self->ahead_known = false;
    return STATUS_OK;
}

void instance_free_saved(void **saved) {
    if (saved != NULL) {
        free(*saved);
        *saved = NULL;
    }
}

status instance_saved_size(instance *self, size_t *size) {
    if (size == NULL) {
        return instance_refuse(self, "a null pointer stands for where the size goes");
    }
    *size = sizeof(snapshot);
    return STATUS_OK;
}

status instance_serialize(instance *self, const void *saved, void *bytes, size_t size) {
    if (saved == NULL || bytes == NULL || !is_ours(saved)) {
        return instance_refuse(self, "what is to be serialized is no saved state of this FMU");
    }
    if (size < sizeof(snapshot)) {
        return instance_refuse(self, "a saved state needs %lu bytes, not %lu", (unsigned long)sizeof(snapshot),
                               (unsigned long)size);
    }
    memcpy(bytes, saved, sizeof(snapshot));
    return STATUS_OK;
}

status instance_deserialize(instance *self, const void *bytes, size_t size, void **saved) {
    uint64_t in;
    if (bytes == NULL || saved == NULL || size != sizeof(snapshot) || !is_ours(bytes)) {
        return instance_refuse(self, "%lu bytes are no saved state of this FMU", (unsigned long)size);
    }
    memcpy(&in, (const char *)bytes + offsetof(snapshot, phase), sizeof in);
    if (in != INSTANTIATED && in != INITIALIZATION && in != STEPPING && in != TERMINATED && in != FAILED) {
        return instance_refuse(self, "the bytes of a saved state were damaged");
    }
    return keep(self, bytes, saved);
}
