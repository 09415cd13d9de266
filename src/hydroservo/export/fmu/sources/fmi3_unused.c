/* The functions of FMI 3.0 that this FMU has no use for. All must exist, and each says why it does nothing. */
#include "instance.h" /* first: it names the prefix of FMI's functions */

#include "fmi3Functions.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

static fmi3Status refuse(fmi3Instance c, const char *reason) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_refuse(c, "%s", reason);
}

static fmi3Status refuse_events(fmi3Instance c) {
    return refuse(c, "this FMU has no event mode");
}

static fmi3Status refuse_clocks(fmi3Instance c) {
    return refuse(c, "this FMU has no clocks");
}

static fmi3Status refuse_exchange(fmi3Instance c) {
    return refuse(c, "this FMU is for co-simulation, not for model exchange");
}

/* --- other interfaces --- */

static fmi3Instance refuse_instance(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logMessage) {
    if (logMessage != NULL) {
        logMessage(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation alone");
    }
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    return refuse_instance(instanceEnvironment, logMessage);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible,
                                               fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption) {
    return refuse_instance(instanceEnvironment, logMessage);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
    return refuse(c, "this FMU is for co-simulation, not for scheduled execution");
}

/* --- variables of types that no variable has --- */

#define LACKS(Type)                                                                                             \
    fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues) {                    \
        return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, #Type);                  \
    }                                                                                                           \
    fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues) {              \
        return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, #Type);                  \
    }

LACKS(Float32)
LACKS(Int8)
LACKS(UInt8)
LACKS(Int16)
LACKS(UInt16)
LACKS(Int32)
LACKS(UInt32)
LACKS(Int64)
LACKS(UInt64)
LACKS(Boolean)
LACKS(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, "Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues) {
    return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, "Binary");
}

/* --- events and clocks --- */

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    return refuse_events(c);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    return refuse_events(c);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    return refuse_events(c);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    return refuse_events(c);
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[]) {
    return refuse_clocks(c);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
    return refuse_clocks(c);
}

/* --- dependencies, derivatives, configuration --- */

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
    return refuse(c, "the dependencies are in the model description alone");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies) {
    return refuse(c, "the dependencies are in the model description alone");
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns,
                                        const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                        size_t nSensitivity) {
    return refuse(c, "directional derivatives are not provided");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    return refuse(c, "adjoint derivatives are not provided");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    return refuse(c, "derivatives of outputs are not provided");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    return refuse(c, "this FMU has no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    return refuse(c, "this FMU has no structural parameters");
}

/* --- model exchange --- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    return refuse_exchange(c);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation) {
    return refuse_exchange(c);
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    return refuse_exchange(c);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 continuousStates[], size_t nContinuousStates) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *nEventIndicators) {
    return refuse_exchange(c);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *nContinuousStates) {
    return refuse_exchange(c);
}
