/* The functions of FMI 2.0 for model exchange. */
#include "equations.h" /* first: it names the prefix of FMI's functions */

#include "fmi2Functions.h"
#include <math.h>

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return (fmi2Status)WITHIN(c, EVENTS | CONTINUOUS, "fmi2EnterEventMode", equations_enter_events(c));
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo) {
    if (!instance_allows(c, EVENTS, "fmi2NewDiscreteStates")) {
        return fmi2Error;
    }
    if (eventInfo == NULL) {
        return (fmi2Status)instance_refuse(
            c, "a null pointer stands for where a result of fmi2NewDiscreteStates goes");
    }
    const status done = equations_update(c, &eventInfo->nextEventTime);
    eventInfo->newDiscreteStatesNeeded = fmi2False;
    eventInfo->terminateSimulation = fmi2False;
    eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    eventInfo->valuesOfContinuousStatesChanged = fmi2False;
    eventInfo->nextEventTimeDefined = isfinite(eventInfo->nextEventTime) ? fmi2True : fmi2False;
    return (fmi2Status)done;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return (fmi2Status)WITHIN(c, EVENTS, "fmi2EnterContinuousTimeMode", equations_enter_continuous(c));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation) {
    (void)noSetFMUStatePriorToCurrentPoint; /* nothing is kept of earlier steps */
    if (!instance_allows(c, CONTINUOUS, "fmi2CompletedIntegratorStep")) {
        return fmi2Error;
    }
    if (enterEventMode == NULL || terminateSimulation == NULL) {
        return (fmi2Status)instance_refuse(c, "a null pointer stands for where a result of "
                                              "fmi2CompletedIntegratorStep goes");
    }
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return (fmi2Status)WITHIN(c, EVENTS | CONTINUOUS, "fmi2SetTime", equations_set_time(c, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    return (fmi2Status)WITHIN(c, CONTINUOUS, "fmi2SetContinuousStates", equations_set_states(c, x, nx));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    return c == NULL ? fmi2Error : (fmi2Status)equations_get_states(c, x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return c == NULL ? fmi2Error : (fmi2Status)equations_get_rates(c, derivatives, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
    return c == NULL ? fmi2Error : (fmi2Status)equations_get_nominals(c, x_nominal, nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni) {
    (void)eventIndicators;
    if (c == NULL) {
        return fmi2Error;
    }
    return ni == 0 ? fmi2OK : (fmi2Status)instance_refuse(c, "this FMU has no event indicators");
}
