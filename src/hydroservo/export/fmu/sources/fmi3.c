/* The functions of FMI 3.0 that every FMU has. */
#include "fmi3_common.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    instance core; /* first, so that it has the address of the whole */
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} component;

static void pass_on(const instance *self, status severity, const char *category, const char *message) {
    const component *whole = (const component *)self;
    if (whole->log != NULL) {
        whole->log(whole->environment, (fmi3Status)severity, category, message);
    }
}

/* Why no instance can be made; NULL if one can. */
static const char *named_wrongly(fmi3String name, fmi3String token) {
    if (name == NULL || name[0] == '\0') {
        return "the name of an instance must not be empty";
    }
    if (token == NULL || strcmp(token, MODEL_TOKEN) != 0) {
        return "the instantiation token is not that of this FMU";
    }
    return NULL;
}

/* --- about the FMU, and the life of an instance --- */

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_log(c, loggingOn, nCategories, categories);
}

fmi3Instance fmi3_begin(const beginning *given, const char *objection) {
    const char *problem = objection != NULL ? objection : named_wrongly(given->name, given->token);
    component *self = problem == NULL ? calloc(1, sizeof *self) : NULL;
    if (self == NULL) {
        if (given->log != NULL) {
            given->log(given->environment, fmi3Error, "logStatusError",
                       problem == NULL ? "there is no memory" : problem);
        }
        return NULL;
    }
    self->log = given->log;
    self->environment = given->environment;
    instance_begin(&self->core, pass_on);
    (void)instance_log(&self->core, given->logging, 0, NULL);
    return self;
}

void fmi3FreeInstance(fmi3Instance c) {
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined,
                                       fmi3Float64 stopTime) {
    (void)toleranceDefined; /* the steps of the integrator are those of the scenario */
    (void)tolerance;
    if (!instance_allows(c, INSTANTIATED, "fmi3EnterInitializationMode") ||
        instance_setup(c, startTime, stopTimeDefined, stopTime) != STATUS_OK) {
        return fmi3Error;
    }
    return (fmi3Status)instance_enter_initialization(c);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    return (fmi3Status)WITHIN(c, INITIALIZATION, "fmi3ExitInitializationMode",
                              instance_exit_initialization(c));
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    return (fmi3Status)WITHIN(c, RUNNING, "fmi3Terminate", instance_terminate(c));
}

fmi3Status fmi3Reset(fmi3Instance c) {
    if (c == NULL) {
        return fmi3Error;
    }
    instance_reset(c);
    return fmi3OK;
}

fmi3Status fmi3_refuse(fmi3Instance c, const char *reason) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_refuse(c, "%s", reason);
}

/* --- variables: all are of type Float64, and scalars --- */

static fmi3Status check_count(fmi3Instance c, size_t references, size_t values) {
    if (c == NULL) {
        return fmi3Error;
    }
    if (references != values) {
        return (fmi3Status)instance_refuse(c,
                                           "%lu value references have %lu values; all variables are scalars",
                                           (unsigned long)references, (unsigned long)values);
    }
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
    if (check_count(c, nValueReferences, nValues) != fmi3OK) {
        return fmi3Error;
    }
    return (fmi3Status)instance_get(c, valueReferences, nValueReferences, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
    if (check_count(c, nValueReferences, nValues) != fmi3OK ||
        !instance_allows(c, INSTANTIATED | INITIALIZATION | RUNNING, "fmi3SetFloat64")) {
        return fmi3Error;
    }
    return (fmi3Status)instance_set(c, valueReferences, nValueReferences, values);
}

/* --- saved states --- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_save(c, FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState FMUState) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_restore(c, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *FMUState) {
    if (c == NULL) {
        return fmi3Error;
    }
    instance_free_saved(FMUState);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState FMUState, size_t *size) {
    (void)FMUState; /* all are of one size */
    return c == NULL ? fmi3Error : (fmi3Status)instance_saved_size(c, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_serialize(c, FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_deserialize(c, serializedState, size, FMUState);
}
