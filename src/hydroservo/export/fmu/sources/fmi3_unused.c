/* The functions of FMI 3.0 that no FMU here has a use for. All must exist; each says why it does nothing. */
#include "fmi3_common.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption) {
    const beginning given = {instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage};
    return fmi3_begin(&given, "this FMU is not for scheduled execution");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
    return fmi3_refuse(c, "this FMU is not for scheduled execution");
}

/* --- variables of types that no variable has --- */

#define LACKS(Type)                                                                                          \
    fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                     \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues) {                 \
        return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, #Type);               \
    }                                                                                                        \
    fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference valueReferences[],                     \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues) {           \
        return c == NULL ? fmi3Error : (fmi3Status)instance_lacks(c, nValueReferences, #Type);               \
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

/* --- dependencies, derivatives, configuration --- */

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
    return fmi3_refuse(c, "the dependencies are in the model description alone");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies) {
    return fmi3_refuse(c, "the dependencies are in the model description alone");
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns,
                                        const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                        size_t nSensitivity) {
    return fmi3_refuse(c, "directional derivatives are not provided");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns,
                                    const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                    size_t nSensitivity) {
    return fmi3_refuse(c, "adjoint derivatives are not provided");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    return fmi3_refuse(c, "this FMU has no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    return fmi3_refuse(c, "this FMU has no structural parameters");
}
