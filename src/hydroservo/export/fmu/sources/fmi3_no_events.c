/* The functions of FMI 3.0 for events, for an FMU that has none. */
#include "fmi3_common.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

static fmi3Status lacks_events(fmi3Instance c) {
    return fmi3_refuse(c, "this FMU has no event mode");
}

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    return lacks_events(c);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    return lacks_events(c);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    return lacks_events(c);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    return lacks_events(c);
}
