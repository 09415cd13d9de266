/* Runs the machine of the tests through FMI 3.0, with every kind of call, right ones and wrong ones. */
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

static fmi3Instance started(const char *name) {
    fmi3Instance c = fmi3InstantiateCoSimulation(name, MODEL_TOKEN, NULL, fmi3False, fmi3True, fmi3False,
                                                 fmi3False, NULL, 0, NULL, count, NULL);
    must(c != NULL, "instantiate");
    must(fmi3EnterInitializationMode(c, fmi3False, 0.0, 0.0, fmi3False, 0.0) == fmi3OK, "enter");
    must(fmi3ExitInitializationMode(c) == fmi3OK, "exit");
    return c;
}

static fmi3Status step(fmi3Instance c, double point, double size) {
    fmi3Boolean events, terminate, early;
    fmi3Float64 last;
    return fmi3DoStep(c, point, size, fmi3True, &events, &terminate, &early, &last);
}

int main(void) {
    const fmi3ValueReference all[] = {0, 1, 2, 3, 4, 5, 6, 7, 8}, command[] = {4},
                             beyond[] = {MODEL_VARIABLES};
    double values[9], u = 1.0;
    fmi3FMUState saved = NULL, again = NULL;
    size_t size;
    fmi3Instance a = started("a"), b = started("b");
    for (int k = 0; k < 1000; k++) {
        must(fmi3SetFloat64(a, command, 1, &u, 1) == fmi3OK, "set");
        must(step(a, k * MODEL_PERIOD, MODEL_PERIOD) == fmi3OK, "step");
        must(fmi3GetFloat64(a, all, 9, values, 9) == fmi3OK, "get");
    }
    must(fmi3GetFMUState(a, &saved) == fmi3OK, "save");
    must(fmi3SerializedFMUStateSize(a, saved, &size) == fmi3OK, "size");
    fmi3Byte *bytes = malloc(size + 1);
    must(bytes != NULL, "memory");
    must(fmi3SerializeFMUState(a, saved, bytes + 1, size) == fmi3OK, "serialize where nothing is aligned");
    must(fmi3DeserializeFMUState(b, bytes + 1, size, &again) == fmi3OK, "deserialize");
    must(fmi3SetFMUState(b, again) == fmi3OK, "restore");
    must(fmi3SerializeFMUState(a, saved, bytes, size - 1) == fmi3Error, "serialize into too little");
    must(fmi3SetFMUState(a, saved) == fmi3OK, "restore after an error");
    must(step(a, 1000 * MODEL_PERIOD, 3e-4) == fmi3Error, "a wrong step");
    must(fmi3GetFloat64(a, beyond, 1, values, 1) == fmi3Error, "a wrong reference");
    must(fmi3SetFloat64(b, all, 9, values, 9) == fmi3Error, "set what is computed");
    must(fmi3Reset(b) == fmi3OK, "reset");
    must(messages == 4, "messages");
    must(fmi3FreeFMUState(a, &saved) == fmi3OK && saved == NULL, "free a state");
    must(fmi3FreeFMUState(b, &again) == fmi3OK && again == NULL, "free the other");
    must(fmi3FreeFMUState(b, NULL) == fmi3OK, "free nothing");
    free(bytes);
    fmi3FreeInstance(a);
    fmi3FreeInstance(b);
    fmi3FreeInstance(NULL);
    printf("2 instances, 1000 samples\n");
    return 0;
}
