/* The functions of FMI 3.0 for model exchange. */
#include "equations.h"
#include "fmi3_common.h"

#include <math.h>

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    (void)resourcePath; /* there are no resources */
    (void)visible;      /* nor windows */
    const beginning given = {instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage};
    return fmi3_begin(&given, NULL);
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    return (fmi3Status)WITHIN(c, EVENTS | CONTINUOUS, "fmi3EnterEventMode", equations_enter_events(c));
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    if (!instance_allows(c, EVENTS, "fmi3EvaluateDiscreteStates")) {
        return fmi3Error;
    }
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    if (!instance_allows(c, EVENTS, "fmi3UpdateDiscreteStates")) {
        return fmi3Error;
    }
    if (discreteStatesNeedUpdate == NULL || terminateSimulation == NULL ||
        nominalsOfContinuousStatesChanged == NULL || valuesOfContinuousStatesChanged == NULL ||
        nextEventTimeDefined == NULL || nextEventTime == NULL) {
        return fmi3_refuse(c, "a null pointer stands for where a result of fmi3UpdateDiscreteStates goes");
    }
    const status done = equations_update(c, nextEventTime);
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = fmi3False;
    *nextEventTimeDefined = isfinite(*nextEventTime);
    return (fmi3Status)done;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    return (fmi3Status)WITHIN(c, EVENTS, "fmi3EnterContinuousTimeMode", equations_enter_continuous(c));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation) {
    (void)noSetFMUStatePriorToCurrentPoint; /* nothing is kept of earlier steps */
    if (!instance_allows(c, CONTINUOUS, "fmi3CompletedIntegratorStep")) {
        return fmi3Error;
    }
    if (enterEventMode == NULL || terminateSimulation == NULL) {
        return fmi3_refuse(c, "a null pointer stands for where a result of fmi3CompletedIntegratorStep goes");
    }
    *enterEventMode = fmi3False;
    *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    return (fmi3Status)WITHIN(c, EVENTS | CONTINUOUS, "fmi3SetTime", equations_set_time(c, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return (fmi3Status)WITHIN(c, CONTINUOUS, "fmi3SetContinuousStates",
                              equations_set_states(c, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 continuousStates[], size_t nContinuousStates) {
    return c == NULL ? fmi3Error : (fmi3Status)equations_get_states(c, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return c == NULL ? fmi3Error : (fmi3Status)equations_get_rates(c, derivatives, nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
    return c == NULL ? fmi3Error : (fmi3Status)equations_get_nominals(c, nominals, nContinuousStates);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
    (void)eventIndicators;
    if (c == NULL) {
        return fmi3Error;
    }
    return nEventIndicators == 0 ? fmi3OK : fmi3_refuse(c, "this FMU has no event indicators");
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *nEventIndicators) {
    if (c == NULL) {
        return fmi3Error;
    }
    if (nEventIndicators == NULL) {
        return fmi3_refuse(c, "a null pointer stands for where a number goes");
    }
    *nEventIndicators = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *nContinuousStates) {
    if (c == NULL) {
        return fmi3Error;
    }
    if (nContinuousStates == NULL) {
        return fmi3_refuse(c, "a null pointer stands for where a number goes");
    }
    *nContinuousStates = MODEL_STATES;
    return fmi3OK;
}
