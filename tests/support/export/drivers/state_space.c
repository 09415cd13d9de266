/* x' = A x + B u, y = C x + D u as an FMU for co-simulation in FMI 3.0, by Euler's method: a step for each
 * communication step. Variables by value reference: sizes m of u, n of x and r of y; A, B, C, D; u, y. */

#include <stdio.h>
#include <stdlib.h>
#include "fmi3Functions.h"

enum { MOST = 5, SIZES = 3, MATRICES = 4, U = 8, Y = 9 };

typedef struct {
    size_t sizes[SIZES]; /* m, n, r */
    double matrices[MATRICES][MOST * MOST];
    double x[MOST], u[MOST];
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} model;

static fmi3Status refused(const model *self, const char *text) {
    self->log(self->environment, fmi3Error, "logStatusError", text);
    return fmi3Error;
}

/* The rows and columns of the matrix at a value reference. */
static void shape(const model *self, fmi3ValueReference reference, size_t *rows, size_t *columns) {
    size_t m = self->sizes[0], n = self->sizes[1], r = self->sizes[2];
    *rows = reference < 6 ? n : r;
    *columns = reference % 2 == 0 ? n : m;
}

/* One row of a matrix times a vector. */
static double row_times(const model *self, fmi3ValueReference reference, size_t row, const double *vector) {
    size_t rows, columns;
    double sum = 0.0;
    shape(self, reference, &rows, &columns);
    for (size_t i = 0; i < columns; i++) {
        sum += self->matrices[reference - 4][row * columns + i] * vector[i];
    }
    return sum;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                         fmi3Boolean early, const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    model *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->sizes[0] = self->sizes[1] = self->sizes[2] = 1;
        self->environment = environment;
        self->log = log;
    }
    return self;
}

void fmi3FreeInstance(fmi3Instance instance) {
    free(instance);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    return fmi3OK;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean known, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stops, fmi3Float64 stop) {
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return fmi3OK;
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt64 values[], size_t given) {
    model *self = instance;
    for (size_t i = 0; i < count; i++) {
        if (values[i] > MOST) {
            return refused(self, "m, n and r are 5 at most");
        }
        self->sizes[references[i] - 1] = values[i];
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t given) {
    model *self = instance;
    const double *next = values;
    for (size_t i = 0; i < count; i++) {
        size_t rows = self->sizes[0], columns = 1;
        double *place = self->u;
        if (references[i] != U) {
            shape(self, references[i], &rows, &columns);
            place = self->matrices[references[i] - 4];
        }
        for (size_t j = 0; j < rows * columns; j++) {
            place[j] = *next++;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t wanted) {
    const model *self = instance;
    double *next = values;
    for (size_t i = 0; i < count; i++) {
        size_t size = references[i] == U ? self->sizes[0] : self->sizes[2];
        for (size_t j = 0; j < size; j++) {
            *next++ = references[i] == U ? self->u[j]
                                         : row_times(self, 6, j, self->x) + row_times(self, 7, j, self->u);
        }
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean kept,
                      fmi3Boolean *event, fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    model *self = instance;
    double rates[MOST];
    for (size_t i = 0; i < self->sizes[1]; i++) {
        rates[i] = row_times(self, 4, i, self->x) + row_times(self, 5, i, self->u);
    }
    for (size_t i = 0; i < self->sizes[1]; i++) {
        self->x[i] += step * rates[i];
    }
    *event = *ends = *early = fmi3False;
    *last = time + step;
    return fmi3OK;
}
