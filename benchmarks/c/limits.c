/* What the processor can do at best: seconds of many independent operations on whole vectors. */
#include <time.h>

typedef double vector __attribute__((vector_size(8 * LANES)));

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* Twelve chains that do not wait for each other, so that none hides how many operations start in a cycle. */
#define TIMED(name, OPERATION)                                                                                   \
    double name(long repeats) {                                                                                  \
        vector x[12], c = {0}, d = {0};                                                                          \
        c += 0.999, d += 1e-3;                                                                                   \
        for (int i = 0; i < 12; i++) x[i] = c + i;                                                               \
        double began = now();                                                                                    \
        for (long k = 0; k < repeats; k++)                                                                       \
            for (int i = 0; i < 12; i++) OPERATION;                                                              \
        double seconds = now() - began;                                                                          \
        for (int i = 0; i < 12; i++) __asm__ volatile("" ::"v"(x[i]));                                           \
        return seconds / (12.0 * repeats);                                                                       \
    }

TIMED(multiply_add, __asm__ volatile("vfmadd213pd %1,%2,%0" : "+v"(x[i]) : "v"(c), "v"(d)))
TIMED(divide, __asm__ volatile("vdivpd %1,%0,%0" : "+v"(x[i]) : "v"(c)))
TIMED(root, __asm__ volatile("vsqrtpd %0,%0" : "+v"(x[i]) :))
