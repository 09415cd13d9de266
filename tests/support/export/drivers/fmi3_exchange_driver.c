/* Integrates equations through FMI 3.0 with Euler's method, with every kind of call, right and wrong. */
#include "driver.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void must(int right, const char *what) {
    if (!right) {
        printf("wrong: %s\n", what);
        exit(1);
    }
}

static int updated(fmi3Instance a) {
    fmi3Boolean again, end, sizes, states, defined;
    fmi3Float64 next;
    return fmi3UpdateDiscreteStates(a, &again, &end, &sizes, &states, &defined, &next) == fmi3OK && !again &&
           !end;
}

int main(void) {
    const fmi3ValueReference beyond[] = {MODEL_VARIABLES};
    double x[MODEL_STATES], rates[MODEL_STATES], sizes[MODEL_STATES], value;
    fmi3Boolean enter, end;
    size_t states, indicators;
    fmi3FMUState saved = NULL;
    must(fmi3InstantiateCoSimulation("a", MODEL_TOKEN, NULL, fmi3False, fmi3True, fmi3False, fmi3False, NULL,
                                     0, NULL, count, NULL) == NULL,
         "another interface");
    fmi3Instance a = fmi3InstantiateModelExchange("a", MODEL_TOKEN, NULL, fmi3False, fmi3True, NULL, count);
    must(a != NULL, "instantiate");
    must(fmi3EnterInitializationMode(a, fmi3False, 0.0, 0.0, fmi3False, 0.0) == fmi3OK, "enter");
    must(fmi3GetContinuousStateDerivatives(a, rates, MODEL_STATES) == fmi3OK, "rates in the initialization");
    must(fmi3ExitInitializationMode(a) == fmi3OK, "exit");
    must(updated(a), "update");
    must(fmi3EnterContinuousTimeMode(a) == fmi3OK, "continuous");
    must(fmi3GetNumberOfContinuousStates(a, &states) == fmi3OK && states == MODEL_STATES, "how many states");
    must(fmi3GetNumberOfEventIndicators(a, &indicators) == fmi3OK && indicators == 0, "how many indicators");
    must(fmi3GetContinuousStates(a, x, MODEL_STATES) == fmi3OK, "states");
    must(fmi3GetNominalsOfContinuousStates(a, sizes, MODEL_STATES) == fmi3OK && sizes[0] > 0.0, "nominals");
    for (int k = 0; k < 1000; k++) {
        must(fmi3SetTime(a, k * 1e-5) == fmi3OK, "time");
        must(fmi3SetContinuousStates(a, x, MODEL_STATES) == fmi3OK, "set states");
        must(fmi3GetContinuousStateDerivatives(a, rates, MODEL_STATES) == fmi3OK, "rates");
        for (unsigned i = 0; i < MODEL_STATES; i++) {
            x[i] += 1e-5 * rates[i];
        }
        must(fmi3CompletedIntegratorStep(a, fmi3True, &enter, &end) == fmi3OK && !enter && !end, "completed");
    }
    must(fmi3EnterEventMode(a) == fmi3OK && updated(a), "event");
    must(fmi3GetFMUState(a, &saved) == fmi3OK, "save");
    must(messages == 1, "messages");
    must(fmi3SetContinuousStates(a, x, MODEL_STATES) == fmi3Error, "states in the event mode");
    must(fmi3SetFMUState(a, saved) == fmi3OK && fmi3EnterContinuousTimeMode(a) == fmi3OK, "restore");
    must(fmi3GetContinuousStateDerivatives(a, rates, MODEL_STATES + 1) == fmi3Error, "too many rates");
    must(fmi3SetFMUState(a, saved) == fmi3OK && fmi3EnterContinuousTimeMode(a) == fmi3OK, "restore again");
    x[0] = NAN;
    must(fmi3SetContinuousStates(a, x, MODEL_STATES) == fmi3Discard, "a state that is no number");
    must(fmi3SetContinuousStates(a, NULL, MODEL_STATES) == fmi3Error, "no states");
    must(fmi3GetFloat64(a, beyond, 1, &value, 1) == fmi3Error, "a wrong reference");
    must(fmi3SetTime(a, 0.0) == fmi3Error, "a call after an error");
    must(fmi3Reset(a) == fmi3OK, "reset");
    must(fmi3GetContinuousStateDerivatives(NULL, rates, MODEL_STATES) == fmi3Error, "no instance");
    must(fmi3FreeFMUState(a, &saved) == fmi3OK, "free a state");
    fmi3FreeInstance(a);
    printf("1 instance, 1000 steps, %.6g\n", rates[1] == rates[1] ? x[1] : 0.0);
    return 0;
}
