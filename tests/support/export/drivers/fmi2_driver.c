/* Runs the machine of the tests through FMI 2.0, with every kind of call, right ones and wrong ones. */
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

static fmi2Component started(const char *name) {
    const fmi2CallbackFunctions callbacks = {count, NULL, NULL, NULL, NULL};
    fmi2Component c =
        fmi2Instantiate(name, fmi2CoSimulation, MODEL_TOKEN, NULL, &callbacks, fmi2False, fmi2True);
    must(c != NULL, "instantiate");
    must(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "setup");
    must(fmi2EnterInitializationMode(c) == fmi2OK, "enter");
    must(fmi2ExitInitializationMode(c) == fmi2OK, "exit");
    return c;
}

int main(void) {
    const fmi2ValueReference all[] = {0, 1, 2, 3, 4, 5, 6, 7, 8}, command[] = {4},
                             beyond[] = {MODEL_VARIABLES};
    double values[9], u = 1.0;
    fmi2FMUstate saved = NULL, again = NULL;
    size_t size;
    fmi2Component a = started("a"), b = started("b");
    for (int k = 0; k < 1000; k++) {
        must(fmi2SetReal(a, command, 1, &u) == fmi2OK, "set");
        must(fmi2DoStep(a, k * MODEL_PERIOD, MODEL_PERIOD, fmi2True) == fmi2OK, "step");
        must(fmi2GetReal(a, all, 9, values) == fmi2OK, "get");
    }
    must(fmi2GetFMUstate(a, &saved) == fmi2OK, "save");
    must(fmi2SerializedFMUstateSize(a, saved, &size) == fmi2OK, "size");
    char *bytes = malloc(size + 1);
    must(bytes != NULL, "memory");
    must(fmi2SerializeFMUstate(a, saved, bytes + 1, size) == fmi2OK, "serialize where nothing is aligned");
    must(fmi2DeSerializeFMUstate(b, bytes + 1, size, &again) == fmi2OK, "deserialize");
    must(fmi2SetFMUstate(b, again) == fmi2OK, "restore");
    must(fmi2SerializeFMUstate(a, saved, bytes, size - 1) == fmi2Error, "serialize into too little");
    must(fmi2SetFMUstate(a, saved) == fmi2OK, "restore after an error");
    must(fmi2DoStep(a, 1000 * MODEL_PERIOD, 3e-4, fmi2True) == fmi2Error, "a wrong step");
    must(fmi2GetReal(a, beyond, 1, values) == fmi2Error, "a wrong reference");
    must(fmi2SetReal(b, all, 9, values) == fmi2Error, "set what is computed");
    must(fmi2Reset(b) == fmi2OK, "reset");
    must(messages == 4, "messages");
    must(fmi2FreeFMUstate(a, &saved) == fmi2OK && saved == NULL, "free a state");
    must(fmi2FreeFMUstate(b, &again) == fmi2OK && again == NULL, "free the other");
    must(fmi2FreeFMUstate(b, NULL) == fmi2OK, "free nothing");
    free(bytes);
    fmi2FreeInstance(a);
    fmi2FreeInstance(b);
    fmi2FreeInstance(NULL);
    printf("2 instances, 1000 samples\n");
    return 0;
}
