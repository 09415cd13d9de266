#include "instance.h"
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

status instance_warn(instance *self, const char *format, ...) {
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

/* The severity of a category; STATUS_OK, which has none, where it is not one of the model description. */
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
            return instance_warn(
                self, "a log category is not one of the model description: messages stay as they were");
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
        return MODEL_CLOCKED ? "in the step mode" : "after the initialization";
    case EVENTS:
        return "in the event mode";
    case CONTINUOUS:
        return "in the continuous-time mode";
    case TICKING:
        return "while the clock is active";
    case TERMINATED:
        return "after the termination";
    default:
        return "after an error, before a reset";
    }
}

bool instance_allows(instance *self, unsigned phases, const char *call) {
    if (self != NULL && (self->now.phase & phases) == 0) {
        (void)instance_refuse(self, "%s must not be called %s", call, phase_text(self->now.phase));
        return false;
    }
    return self != NULL;
}

status instance_lacks(instance *self, size_t count, const char *type) {
    return count == 0 ? STATUS_OK : instance_refuse(self, "no variable is of type %s", type);
}

/* --- numbers --- */

double instance_number(const model_numbers *numbers, const model_variable *variable) {
    double value;
    memcpy(&value, (const char *)numbers + variable->place, sizeof value);
    return value;
}

static bool is_parameter(const model_variable *variable) {
    return variable->kind == VARIABLE_FIXED || variable->kind == VARIABLE_TUNABLE;
}

static status check_references(instance *self, const unsigned references[], size_t count,
                               const double values[]) {
    if (count > 0 && (references == NULL || values == NULL)) {
        return instance_refuse(self, "a null pointer stands for %lu value references or values",
                               (unsigned long)count);
    }
    for (size_t i = 0; i < count; i++) {
        if (references[i] >= MODEL_VARIABLES) {
            return instance_refuse(self, "no variable of this type has the value reference %u",
                                   references[i]);
        }
    }
    return STATUS_OK;
}

static status out_of_range(instance *self, const model_variable *variable, double value) {
    if (isfinite(variable->most)) {
        return instance_discard(self,
                                "%s stays as it is and is not set to %.10g: it lies from %.10g to %.10g",
                                variable->name, value, variable->least, variable->most);
    }
    if (variable->least > 0.0 && variable->least < DBL_MIN) {
        return instance_discard(self, "%s stays as it is and is not set to %.10g: it must be above 0",
                                variable->name, value);
    }
    return instance_discard(self, "%s stays as it is and is not set to %.10g: it must be at least %.10g",
                            variable->name, value, variable->least);
}

/* One state by its reference, as all of them in an array. */
static status check_state(instance *self, const model_variable *variable, double value) {
    if (isnan(value)) {
        return instance_discard(self, "%s stays as it is and is not set to %g: a state is a number",
                                variable->name, value);
    }
    return STATUS_OK;
}

static status check_value(instance *self, const model_variable *variable, double value) {
    if (variable->kind == VARIABLE_CONSTANT) {
        return instance_refuse(self, "%s cannot be set: it is constant", variable->name);
    }
    if (variable->kind == VARIABLE_INTEGRATED && self->now.phase == CONTINUOUS) {
        return check_state(self, variable, value);
    }
    if (!is_parameter(variable) && variable->kind != VARIABLE_INPUT) {
        return instance_refuse(self, "%s cannot be set: the model computes it", variable->name);
    }
    if (variable->kind == VARIABLE_FIXED && (self->now.phase & RUNNING) != 0) {
        return instance_refuse(self, "%s cannot be set after the initialization: it is read there alone",
                               variable->name);
    }
    if (MODEL_CLOCKED && variable->kind == VARIABLE_INPUT && (self->now.phase & (STEPPING | EVENTS)) != 0) {
        return instance_refuse(self, "%s cannot be set while its clock, %s, is not active", variable->name,
                               MODEL_CLOCK_NAME);
    }
    if (is_parameter(variable) && self->now.phase == CONTINUOUS) {
        return instance_refuse(self, "%s cannot be set in the continuous-time mode: it is a parameter",
                               variable->name);
    }
    if (is_parameter(variable) && !isfinite(value)) {
        return instance_discard(self,
                                "%s stays as it is and is not set to %g: a parameter is a finite number",
                                variable->name, value);
    }
    if (is_parameter(variable) && !(value >= variable->least && value <= variable->most)) {
        return out_of_range(self, variable, value);
    }
    return STATUS_OK;
}

/* True where what is asked for is what the model makes of its inputs, though it has not taken them yet. */
static bool looks_ahead(const instance *self) {
    if (MODEL_CLOCKED) {
        return self->now.phase == TICKING;
    }
    return MODEL_FEEDS_THROUGH && self->now.given != 0 && self->now.phase != INSTANTIATED;
}

const model_numbers *instance_numbers(instance *self) {
    if (!looks_ahead(self)) {
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
    const model_numbers *numbers = instance_numbers(self);
    for (size_t i = 0; i < count; i++) {
        const model_variable *variable = &model_variables[references[i]];
        values[i] =
            variable->kind == VARIABLE_TIME ? instance_time(self) : instance_number(numbers, variable);
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
    if ((self->now.phase & RUNNING) == 0) {
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
    self->now.jump = INFINITY;
    self->now.given = MODEL_EXCHANGES;
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
        return instance_refuse(self, "the stop time of %.10g s comes before the start time of %.10g s", stop,
                               start);
    }
    self->now.start = start;
    self->now.time = start;
    self->now.due = start;
    self->now.stop = stop_defined ? stop : INFINITY;
    return STATUS_OK;
}

status instance_enter_initialization(instance *self) {
    self->now.phase = INITIALIZATION;
    return STATUS_OK;
}

status instance_exit_initialization(instance *self) {
    for (size_t i = 0; i < MODEL_VARIABLES; i++) {
        const model_variable *variable = &model_variables[i];
        if (variable->vital && !isfinite(instance_number(&self->now.numbers, variable))) {
            return instance_refuse(self, "%s is not finite after the initialization", variable->name);
        }
    }
    self->now.phase = MODEL_EXCHANGES || MODEL_CLOCKED ? EVENTS : STEPPING;
    return STATUS_OK;
}

status instance_terminate(instance *self) {
    self->now.phase = TERMINATED;
    return STATUS_OK;
}

double instance_time(const instance *self) {
    const bool of_importer = MODEL_EXCHANGES || MODEL_CLOCKED;
    return of_importer ? self->now.time : self->now.start + (double)self->now.samples * MODEL_PERIOD;
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
        return instance_refuse(self, "a saved state needs %lu bytes, not %lu",
                               (unsigned long)sizeof(snapshot), (unsigned long)size);
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
    for (uint64_t known = INSTANTIATED; in != known; known *= 2) {
        if (known == LAST_PHASE) {
            return instance_refuse(self, "the bytes of a saved state were damaged");
        }
    }
    return keep(self, bytes, saved);
}
