/* Loads the library of an FMU and steps it: runner LIBRARY TOKEN < rows. The macro FMI is its version.

   All numbers that it reads and prints are 64 bits in hexadecimal. It reads the sample period, the numbers of
   inputs, outputs and samples, the references of inputs and outputs, and the inputs of each sample. It prints
   the outputs once the inputs of a sample are set, and again after its step; at the end, the answer to a
   wrong step. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2Component instance;
typedef fmi2ValueReference reference;
#else
#include "fmi3Functions.h"
typedef fmi3Instance instance;
typedef fmi3ValueReference reference;
#endif

#ifdef _WIN32
#include <windows.h>
typedef HMODULE library;
typedef FARPROC function;
static library opened(const char *path) {
    return LoadLibraryA(path);
}
static function named(library from, const char *name) {
    return GetProcAddress(from, name);
}
#else
#include <dlfcn.h>
typedef void *library;
typedef void *function;
static library opened(const char *path) {
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}
static function named(library from, const char *name) {
    return dlsym(from, name);
}
#endif

enum { MOST = 200 };

static library fmu;

static function entry(const char *name) {
    function found = named(fmu, name);
    if (found == NULL) {
        printf("there is no %s\n", name);
        exit(1);
    }
    return found;
}

#define CALL(name) ((name##TYPE *)(uintptr_t)entry(#name))

static void must(int right, const char *what) {
    if (!right) {
        printf("wrong: %s\n", what);
        exit(1);
    }
}

static uint64_t word(void) {
    uint64_t found;
    must(scanf("%" SCNx64, &found) == 1, "input");
    return found;
}

static double number(void) {
    uint64_t bits = word();
    double found;
    memcpy(&found, &bits, sizeof found);
    return found;
}

#if FMI == 2

static void heard(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                  fmi2String category, fmi2String message, ...) {
    (void)environment;
    printf("%s: %d %s %s\n", name, (int)status, category, message);
}

static instance started(const char *token) {
    static const fmi2CallbackFunctions callbacks = {heard, NULL, NULL, NULL, NULL};
    instance c = CALL(fmi2Instantiate)("one", fmi2CoSimulation, token, NULL, &callbacks, fmi2False, fmi2True);
    must(c != NULL, "instantiate");
    must(CALL(fmi2SetupExperiment)(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "setup");
    must(CALL(fmi2EnterInitializationMode)(c) == fmi2OK, "enter");
    must(CALL(fmi2ExitInitializationMode)(c) == fmi2OK, "exit");
    return c;
}

static void set(instance c, const reference *references, size_t count, const double *values) {
    must(CALL(fmi2SetReal)(c, references, count, values) == fmi2OK, "set");
}

static void get(instance c, const reference *references, size_t count, double *values) {
    must(CALL(fmi2GetReal)(c, references, count, values) == fmi2OK, "get");
}

static int step(instance c, double point, double size) {
    return (int)CALL(fmi2DoStep)(c, point, size, fmi2True);
}

static void freed(instance c) {
    CALL(fmi2FreeInstance)(c);
}

#else

static void heard(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                  fmi3String message) {
    (void)environment;
    printf("one: %d %s %s\n", (int)status, category, message);
}

static instance started(const char *token) {
    instance c = CALL(fmi3InstantiateCoSimulation)("one", token, NULL, fmi3False, fmi3True, fmi3False,
                                                   fmi3False, NULL, 0, NULL, heard, NULL);
    must(c != NULL, "instantiate");
    must(CALL(fmi3EnterInitializationMode)(c, fmi3False, 0.0, 0.0, fmi3False, 0.0) == fmi3OK, "enter");
    must(CALL(fmi3ExitInitializationMode)(c) == fmi3OK, "exit");
    return c;
}

static void set(instance c, const reference *references, size_t count, const double *values) {
    must(CALL(fmi3SetFloat64)(c, references, count, values, count) == fmi3OK, "set");
}

static void get(instance c, const reference *references, size_t count, double *values) {
    must(CALL(fmi3GetFloat64)(c, references, count, values, count) == fmi3OK, "get");
}

static int step(instance c, double point, double size) {
    fmi3Boolean events, terminate, early;
    fmi3Float64 last;
    return (int)CALL(fmi3DoStep)(c, point, size, fmi3True, &events, &terminate, &early, &last);
}

static void freed(instance c) {
    CALL(fmi3FreeInstance)(c);
}

#endif

static void shown(instance c, const reference *references, size_t count) {
    double values[MOST];
    get(c, references, count, values);
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        printf("%016" PRIx64 " ", bits);
    }
    printf("\n");
}

int main(int count, char *words[]) {
    reference given[MOST], asked[MOST];
    double values[MOST];
    must(count == 3, "arguments");
    fmu = opened(words[1]);
    must(fmu != NULL, "open");
    const double period = number();
    const size_t inputs = (size_t)word(), outputs = (size_t)word(), samples = (size_t)word();
    must(inputs <= MOST && outputs <= MOST, "too many variables");
    for (size_t i = 0; i < inputs; i++) {
        given[i] = (reference)word();
    }
    for (size_t i = 0; i < outputs; i++) {
        asked[i] = (reference)word();
    }
    instance c = started(words[2]);
    for (size_t k = 0; k < samples; k++) {
        for (size_t i = 0; i < inputs; i++) {
            values[i] = number();
        }
        if (inputs > 0) {
            set(c, given, inputs, values);
        }
        shown(c, asked, outputs);
        must(step(c, (double)k * period, period) < 2, "step");
        shown(c, asked, outputs);
    }
    printf("%d\n", step(c, (double)samples * period, 0.3 * period));
    freed(c);
    return 0;
}
