/* The functions of FMI 3.0 for co-simulation, but for those of the event mode. */
#include "fmi3_common.h"
#include "steps.h"

/* Why no instance can be made of what is asked for; NULL if one can. */
static const char *objection(fmi3Boolean events, size_t intermediate) {
    if (events != MODEL_CLOCKED) {
        return MODEL_CLOCKED ? "this FMU has a clock, which needs the event mode (eventModeUsed)"
                             : "this FMU has no event mode";
    }
    return intermediate > 0 ? "this FMU has no intermediate update" : NULL;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    (void)resourcePath;       /* there are no resources */
    (void)visible;            /* nor windows */
    (void)earlyReturnAllowed; /* no step returns early */
    (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    const beginning given = {instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage};
    return fmi3_begin(&given, objection(eventModeUsed, nRequiredIntermediateVariables));
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    (void)noSetFMUStatePriorToCurrentPoint; /* nothing is kept of earlier steps */
    if (!instance_allows(c, STEPPING, "fmi3DoStep")) {
        return fmi3Error;
    }
    if (eventHandlingNeeded == NULL || terminateSimulation == NULL || earlyReturn == NULL ||
        lastSuccessfulTime == NULL) {
        return (fmi3Status)instance_refuse(c, "a null pointer stands for where a result of fmi3DoStep goes");
    }
    const status reached = steps_take(c, currentCommunicationPoint, communicationStepSize);
    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
    *lastSuccessfulTime = instance_time(c);
    return (fmi3Status)reached;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    (void)valueReferences;
    (void)nValueReferences;
    (void)orders;
    (void)values;
    (void)nValues;
    return fmi3_refuse(c, "derivatives of outputs are not provided");
}
