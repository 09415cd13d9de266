/* The functions of FMI 3.0 for model exchange, for an FMU of co-simulation. */
#include "fmi3_common.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

static fmi3Status lacks_equations(fmi3Instance c) {
    return fmi3_refuse(c, "this FMU is for co-simulation, not for model exchange");
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    const beginning given = {instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage};
    return fmi3_begin(&given, "this FMU is for co-simulation alone");
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    return lacks_equations(c);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation) {
    return lacks_equations(c);
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    return lacks_equations(c);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return lacks_equations(c);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return lacks_equations(c);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
    return lacks_equations(c);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 continuousStates[], size_t nContinuousStates) {
    return lacks_equations(c);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
    return lacks_equations(c);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *nEventIndicators) {
    return lacks_equations(c);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *nContinuousStates) {
    return lacks_equations(c);
}
