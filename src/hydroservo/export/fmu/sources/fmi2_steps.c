/* The functions of FMI 2.0 for co-simulation. */
#include "steps.h" /* first: it names the prefix of FMI's functions */

#include "fmi2Functions.h"

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    (void)noSetFMUStatePriorToCurrentPoint; /* nothing is kept of earlier steps */
    return (fmi2Status)WITHIN(c, STEPPING, "fmi2DoStep",
                              steps_take(c, currentCommunicationPoint, communicationStepSize));
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
    if (c == NULL || value == NULL) {
        return fmi2Error;
    }
    if (s != fmi2LastSuccessfulTime) {
        return (fmi2Status)instance_discard(c, "of the real states of a step, only the last time is known");
    }
    *value = instance_time(c);
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
    if (c == NULL || value == NULL) {
        return fmi2Error;
    }
    if (s != fmi2Terminated) {
        return (fmi2Status)instance_discard(c,
                                            "of the logical states of a step, only its termination is known");
    }
    *value = fmi2False; /* this FMU never ends a run by itself */
    return fmi2OK;
}

/* --- what this FMU does not do: steps that run on their own, interpolation, derivatives --- */

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

fmi2Status fmi2CancelStep(fmi2Component c) {
    return c == NULL ? fmi2Error
                     : (fmi2Status)instance_refuse(c, "no step is pending that could be cancelled");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_discard(c, "no step is pending");
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_discard(c, "a step has no state that is an integer");
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_discard(c, "no step is pending");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    return c == NULL ? fmi2Error
                     : (fmi2Status)instance_refuse(c, "inputs are held over a step, not interpolated");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    return c == NULL ? fmi2Error : (fmi2Status)instance_refuse(c, "derivatives of outputs are not provided");
}
