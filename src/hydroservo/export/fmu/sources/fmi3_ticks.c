/* The functions of FMI 3.0 for an event mode with a clock, which is periodic and constant. */
#include "fmi3_common.h"
#include "ticks.h"

#define AT_EVENTS (EVENTS | TICKING)

/* --- the event mode --- */

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    if (!instance_allows(c, STEPPING, "fmi3EnterEventMode")) {
        return fmi3Error;
    }
    ticks_enter_events(c);
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    if (!instance_allows(c, EVENTS, "fmi3EnterStepMode")) {
        return fmi3Error;
    }
    ticks_leave_events(c);
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    return fmi3_refuse(c, "discrete states are evaluated where they are asked for, not by a call");
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime) {
    if (!instance_allows(c, AT_EVENTS, "fmi3UpdateDiscreteStates")) {
        return fmi3Error;
    }
    if (discreteStatesNeedUpdate == NULL || terminateSimulation == NULL ||
        nominalsOfContinuousStatesChanged == NULL || valuesOfContinuousStatesChanged == NULL ||
        nextEventTimeDefined == NULL || nextEventTime == NULL) {
        return fmi3_refuse(c, "a null pointer stands for where a result of fmi3UpdateDiscreteStates goes");
    }
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = fmi3False;
    *nextEventTimeDefined = fmi3False; /* the clock's interval says when it ticks */
    *nextEventTime = 0.0;
    return (fmi3Status)ticks_update(c);
}

/* --- the clock --- */

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[]) {
    if (c == NULL || ticks_expect_clock(c, valueReferences, nValueReferences, values) != STATUS_OK) {
        return fmi3Error;
    }
    for (size_t i = 0; i < nValueReferences; i++) {
        values[i] = ticks_active(c);
    }
    return fmi3OK;
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[]) {
    if (!instance_allows(c, AT_EVENTS, "fmi3SetClock") ||
        ticks_expect_clock(c, valueReferences, nValueReferences, values) != STATUS_OK) {
        return fmi3Error;
    }
    for (size_t i = 0; i < nValueReferences; i++) {
        if (ticks_set(c, values[i]) != STATUS_OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    if (!instance_allows(c, INITIALIZATION | AT_EVENTS, "fmi3GetIntervalDecimal") ||
        ticks_expect_clock(c, valueReferences, nValueReferences, intervals) != STATUS_OK ||
        ticks_expect_clock(c, valueReferences, nValueReferences, qualifiers) != STATUS_OK) {
        return fmi3Error;
    }
    for (size_t i = 0; i < nValueReferences; i++) {
        intervals[i] = MODEL_PERIOD;
        qualifiers[i] = fmi3IntervalUnchanged; /* the model description says it, and it is constant */
    }
    return fmi3OK;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
    if (!instance_allows(c, INITIALIZATION | AT_EVENTS, "fmi3GetShiftDecimal") ||
        ticks_expect_clock(c, valueReferences, nValueReferences, shifts) != STATUS_OK) {
        return fmi3Error;
    }
    for (size_t i = 0; i < nValueReferences; i++) {
        shifts[i] = 0.0;
    }
    return fmi3OK;
}

/* --- what a constant clock without fractions does not do --- */

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter" /* C99 has no parameters without a name */
#endif

static fmi3Status is_constant(fmi3Instance c) {
    return fmi3_refuse(c, "the interval and the shift of the clock are constant");
}

static fmi3Status lacks_fractions(fmi3Instance c) {
    return fmi3_refuse(c, "the interval and the shift of the clock are decimals, not fractions");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
    return is_constant(c);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[]) {
    return is_constant(c);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
    return is_constant(c);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
    return is_constant(c);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    return lacks_fractions(c);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
    return lacks_fractions(c);
}
