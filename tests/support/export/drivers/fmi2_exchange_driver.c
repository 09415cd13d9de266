/* Integrates equations through FMI 2.0 with Euler's method, with every kind of call, right and wrong. */
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

int main(void) {
    const fmi2CallbackFunctions callbacks = {count, NULL, NULL, NULL, NULL};
    const fmi2ValueReference beyond[] = {MODEL_VARIABLES};
    double x[MODEL_STATES], rates[MODEL_STATES], sizes[MODEL_STATES], value;
    fmi2EventInfo events;
    fmi2Boolean enter, end;
    fmi2FMUstate saved = NULL;
    must(fmi2Instantiate("a", fmi2CoSimulation, MODEL_TOKEN, NULL, &callbacks, fmi2False, fmi2True) == NULL,
         "another interface");
    fmi2Component a =
        fmi2Instantiate("a", fmi2ModelExchange, MODEL_TOKEN, NULL, &callbacks, fmi2False, fmi2True);
    must(a != NULL, "instantiate");
    must(fmi2SetupExperiment(a, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "setup");
    must(fmi2EnterInitializationMode(a) == fmi2OK, "enter");
    must(fmi2GetDerivatives(a, rates, MODEL_STATES) == fmi2OK, "rates in the initialization");
    must(fmi2ExitInitializationMode(a) == fmi2OK, "exit");
    must(fmi2NewDiscreteStates(a, &events) == fmi2OK && events.nextEventTimeDefined == fmi2True, "update");
    must(fmi2EnterContinuousTimeMode(a) == fmi2OK, "continuous");
    must(fmi2GetContinuousStates(a, x, MODEL_STATES) == fmi2OK, "states");
    must(fmi2GetNominalsOfContinuousStates(a, sizes, MODEL_STATES) == fmi2OK && sizes[0] > 0.0, "nominals");
    for (int k = 0; k < 1000; k++) {
        must(fmi2SetTime(a, k * 1e-5) == fmi2OK, "time");
        must(fmi2SetContinuousStates(a, x, MODEL_STATES) == fmi2OK, "set states");
        must(fmi2GetDerivatives(a, rates, MODEL_STATES) == fmi2OK, "rates");
        for (unsigned i = 0; i < MODEL_STATES; i++) {
            x[i] += 1e-5 * rates[i];
        }
        must(fmi2CompletedIntegratorStep(a, fmi2True, &enter, &end) == fmi2OK && !enter && !end, "completed");
    }
    must(fmi2EnterEventMode(a) == fmi2OK && fmi2NewDiscreteStates(a, &events) == fmi2OK, "event");
    must(fmi2GetFMUstate(a, &saved) == fmi2OK, "save");
    must(messages == 1, "messages");
    must(fmi2SetContinuousStates(a, x, MODEL_STATES) == fmi2Error, "states in the event mode");
    must(fmi2SetFMUstate(a, saved) == fmi2OK && fmi2EnterContinuousTimeMode(a) == fmi2OK, "restore");
    must(fmi2GetDerivatives(a, rates, MODEL_STATES + 1) == fmi2Error, "too many rates");
    must(fmi2SetFMUstate(a, saved) == fmi2OK && fmi2EnterContinuousTimeMode(a) == fmi2OK, "restore again");
    x[0] = NAN;
    must(fmi2SetContinuousStates(a, x, MODEL_STATES) == fmi2Discard, "a state that is no number");
    must(fmi2SetContinuousStates(a, NULL, MODEL_STATES) == fmi2Error, "no states");
    must(fmi2GetReal(a, beyond, 1, &value) == fmi2Error, "a wrong reference");
    must(fmi2SetTime(a, 0.0) == fmi2Error, "a call after an error");
    must(fmi2Reset(a) == fmi2OK, "reset");
    must(fmi2GetDerivatives(NULL, rates, MODEL_STATES) == fmi2Error, "no instance");
    must(fmi2FreeFMUstate(a, &saved) == fmi2OK, "free a state");
    fmi2FreeInstance(a);
    printf("1 instance, 1000 steps, %.6g\n", rates[1] == rates[1] ? x[1] : 0.0);
    return 0;
}
