/* The functions of FMI 2.0 that every FMU has. */
#include "instance.h" /* first: it names the prefix of FMI's functions */

#include "fmi2Functions.h"
#include <stdlib.h>
#include <string.h>

typedef struct {
    instance core; /* first, so that it has the address of the whole */
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[];
} component;

static void pass_on(const instance *self, status severity, const char *category, const char *message) {
    const component *whole = (const component *)self;
    if (whole->logger != NULL) {
        whole->logger(whole->environment, whole->name, (fmi2Status)severity, category, message);
    }
}

/* Why no instance can be made; NULL if one can. */
static const char *objection(fmi2String name, fmi2Type type, fmi2String guid) {
    if (name == NULL || name[0] == '\0') {
        return "the name of an instance must not be empty";
    }
    if (type != (MODEL_EXCHANGES ? fmi2ModelExchange : fmi2CoSimulation)) {
        return MODEL_EXCHANGES ? "this FMU is for model exchange alone"
                               : "this FMU is for co-simulation alone";
    }
    if (guid == NULL || strcmp(guid, MODEL_TOKEN) != 0) {
        return "the GUID is not that of this FMU";
    }
    return NULL;
}

/* --- about the FMU, and the life of an instance --- */

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    return c == NULL ? fmi2Error
                     : (fmi2Status)instance_log(c, loggingOn != fmi2False, nCategories, categories);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    (void)fmuResourceLocation; /* there are no resources */
    (void)visible;             /* nor windows */
    const char *problem = objection(instanceName, fmuType, fmuGUID);
    const size_t length = instanceName == NULL ? 0 : strlen(instanceName);
    component *self = problem == NULL ? calloc(1, sizeof *self + length + 1) : NULL;
    if (self == NULL) {
        if (functions != NULL && functions->logger != NULL) {
            functions->logger(functions->componentEnvironment, length == 0 ? MODEL_IDENTIFIER : instanceName,
                              fmi2Error, "logStatusError", problem == NULL ? "there is no memory" : problem);
        }
        return NULL;
    }
    memcpy(self->name, instanceName, length);
    if (functions != NULL) {
        self->logger = functions->logger;
        self->environment = functions->componentEnvironment;
    }
    instance_begin(&self->core, pass_on);
    (void)instance_log(&self->core, loggingOn != fmi2False, 0, NULL);
    return self;
}

void fmi2FreeInstance(fmi2Component c) {
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    (void)toleranceDefined; /* the steps of the integrator are those of the scenario */
    (void)tolerance;
    return (fmi2Status)WITHIN(c, INSTANTIATED, "fmi2SetupExperiment",
                              instance_setup(c, startTime, stopTimeDefined != fmi2False, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return (fmi2Status)WITHIN(c, INSTANTIATED, "fmi2EnterInitializationMode",
                              instance_enter_initialization(c));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return (fmi2Status)WITHIN(c, INITIALIZATION, "fmi2ExitInitializationMode",
                              instance_exit_initialization(c));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return (fmi2Status)WITHIN(c, RUNNING, "fmi2Terminate", instance_terminate(c));
}

fmi2Status fmi2Reset(fmi2Component c) {
    if (c == NULL) {
        return fmi2Error;
    }
    instance_reset(c);
    return fmi2OK;
}

/* --- variables: all are real --- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_get(c, vr, nvr, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    return (fmi2Status)WITHIN(c, INSTANTIATED | INITIALIZATION | RUNNING, "fmi2SetReal",
                              instance_set(c, vr, nvr, value));
}

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

#define LACKS(Type)                                                                                          \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                     \
                             fmi2##Type value[]) {                                                           \
        return c == NULL ? fmi2Error : (fmi2Status)instance_lacks(c, nvr, #Type);                            \
    }                                                                                                        \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                     \
                             const fmi2##Type value[]) {                                                     \
        return c == NULL ? fmi2Error : (fmi2Status)instance_lacks(c, nvr, #Type);                            \
    }

LACKS(Integer)
LACKS(Boolean)
LACKS(String)

/* --- saved states --- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_save(c, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_restore(c, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    if (c == NULL) {
        return fmi2Error;
    }
    instance_free_saved(FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    (void)FMUstate; /* all are of one size */
    return c == NULL ? fmi2Error : (fmi2Status)instance_saved_size(c, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_serialize(c, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_deserialize(c, serializedState, size, FMUstate);
}

/* --- what this FMU does not do --- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[]) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_refuse(c, "directional derivatives are not provided");
}
