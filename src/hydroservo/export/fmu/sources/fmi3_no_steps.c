/* The functions of FMI 3.0 for co-simulation, for an FMU of model exchange. */
#include "fmi3_common.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

static fmi3Status lacks_steps(fmi3Instance c) {
    return fmi3_refuse(c, "this FMU is for model exchange, not for co-simulation");
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    const beginning given = {instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage};
    return fmi3_begin(&given, "this FMU is for model exchange alone");
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    return lacks_steps(c);
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    return lacks_steps(c);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    return lacks_steps(c);
}
