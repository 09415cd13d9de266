/* The closed loop over all samples for many runs on a CUDA device, a thread a run: -DSINGLE for floats.

   What all runs have in common, the demand and the load, is computed once for the threads of a block: each does one
   of the samples to come and leaves it in shared memory. A block that has lost all of its runs stops. */
#define LANES 1
#include "laws.h"
#include "metrics.h"

#define THREADS 64

typedef struct {
    Nominal nominal;
    Law law;
    Wave reference, load;
    double dt;
    long samples;
} Common;

typedef struct {
    Demand demand;
    number start, middle, end;
} Signals;

INLINE Signals signals_at(const Common *c, long k) {
    const double t = (double)k * c->dt;
    return (Signals){demand_at(c->reference, t), (number)wave_at(c->load, t), (number)wave_at(c->load, t + 0.5 * c->dt),
                     (number)wave_at(c->load, t + c->dt)};
}

__global__ void __launch_bounds__(THREADS) loop(const __grid_constant__ Common c, const Given *given, long count,
                                                double *out, long metrics) {
    __shared__ Signals signals[THREADS];
    const long run = (long)blockIdx.x * THREADS + threadIdx.x;
    const Given *own = given + (run < count ? run : count - 1); /* threads beyond the last run repeat it */
    const double half = 0.5 * (double)(c.samples - 1) * c.dt;
    const number dt = (number)c.dt;
    Machine machine;
    set_machine(&machine, 0, own);
    Plant x = {0, 0, (number)own->start_position};
    Controller s = {};
    Sums sums = no_sums();
    int alive = 1;
    for (long first = 0; first < c.samples && __syncthreads_or(alive); first += THREADS) {
        signals[threadIdx.x] = signals_at(&c, first + threadIdx.x);
        __syncthreads();
        const long last = first + THREADS < c.samples ? first + THREADS : c.samples;
        for (long k = first; k < last; k++) {
            const Signals now = signals[k - first];
            const Lumped estimate = control(&c.nominal, &c.law, x, now.demand, &s);
            const Valve valve = valve_at(&machine, s.u);
            const Plant k1 = rates(&machine, valve, x, now.start);
            const Lumped actual = lumped(&c.nominal, x, s.u, k1);
            const Plant next = rk4(&machine, x, dt, k1, valve, now.middle, valve, now.end);
            measure(&sums, (double)k * c.dt, half, k == c.samples - 1, now.demand, x, s.u, actual, estimate);
            x = next;
        }
        alive = any_finite(x.velocity) && any_finite(x.force);
    }
    if (run < count) report(&sums, 0, c.samples, out + run * metrics);
}

/* What the device has to say of it: nothing if it did all runs. */
extern "C" const char *closed_loop(const Given *given, long count, long samples, double dt, double *out, long metrics) {
    const Common common = {nominal_of(given), law_of(given, dt),
                           wave_of(given->reference_amplitude, given->reference_frequency),
                           wave_of(given->load_amplitude, given->load_frequency), dt, samples};
    Given *there = NULL;
    double *found = NULL;
    cudaMalloc(&there, sizeof(Given) * count);
    cudaMalloc(&found, sizeof(double) * count * metrics);
    cudaMemcpy(there, given, sizeof(Given) * count, cudaMemcpyHostToDevice);
    loop<<<(count + THREADS - 1) / THREADS, THREADS>>>(common, there, count, found, metrics);
    cudaMemcpy(out, found, sizeof(double) * count * metrics, cudaMemcpyDeviceToHost);
    cudaFree(there);
    cudaFree(found);
    const cudaError_t error = cudaGetLastError();
    return error == cudaSuccess ? NULL : cudaGetErrorString(error);
}
