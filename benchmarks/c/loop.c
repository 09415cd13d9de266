/* The closed loop over all samples for many runs, LANES of them in a vector (one at a time if LANES is 1).

   GROUPS vectors advance together, so that the processor finds independent work while it waits for a power or a
   root. Built with -DLANES=1, 4 or 8 and -DGROUPS=... */
#include "laws.h"
#include "metrics.h"

#define WIDTH (LANES * GROUPS)

typedef struct {
    Machine machine;
    Plant x;
    Controller s;
    Sums sums;
} Runs;

static void together(const Given *given, long count, long samples, double dt, double *out, long metrics) {
    Runs runs[GROUPS] = {};
    for (long i = 0; i < WIDTH; i++) /* lanes beyond the last run repeat it */
        set_machine(&runs[i / LANES].machine, (int)(i % LANES), given + (i < count ? i : count - 1));
    for (int g = 0; g < GROUPS; g++) {
        runs[g].x.position = same(given->start_position);
        runs[g].sums = no_sums();
    }
    const Nominal nominal = nominal_of(given);
    const Law law = law_of(given, dt);
    const Wave reference = wave_of(given->reference_amplitude, given->reference_frequency);
    const Wave load = wave_of(given->load_amplitude, given->load_frequency);
    const double half = 0.5 * (double)(samples - 1) * dt;
    int alive = 1;
    for (long k = 0; k < samples && alive; k++) {
        const double t = (double)k * dt;
        const Demand r = demand_at(reference, t);
        Lumped estimates[GROUPS];
        for (int g = 0; g < GROUPS; g++) estimates[g] = control(&nominal, &law, runs[g].x, r, &runs[g].s);
        /* Here, and not with the demand: the processor has time for it while the chain through control is not done. */
        const double start = wave_at(load, t), middle = wave_at(load, t + 0.5 * dt), end = wave_at(load, t + dt);
        alive = 0;
        for (int g = 0; g < GROUPS; g++) {
            const Machine *m = &runs[g].machine;
            const Plant x = runs[g].x;
            const real u = runs[g].s.u;
            const Valve valve = valve_at(m, u);
            const Plant k1 = rates(m, valve, x, start);
            runs[g].x = rk4(m, x, dt, k1, valve, middle, valve, end);
            measure(&runs[g].sums, t, half, k == samples - 1, r, x, u, lumped(&nominal, x, u, k1), estimates[g]);
            alive |= any_finite(runs[g].x.velocity) && any_finite(runs[g].x.force);
        }
    }
    for (long i = 0; i < WIDTH && i < count; i++)
        report(&runs[i / LANES].sums, (int)(i % LANES), samples, out + i * metrics);
}

void closed_loop(const Given *given, long count, long samples, double dt, int threads, double *out, long metrics) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (long i = 0; i < count; i += WIDTH) together(given + i, count - i, samples, dt, out + i * metrics, metrics);
}

#if LANES == 1
/* The machine alone under the command amplitude sin(2 pi frequency t); its state at the end. */
void plant(const Given *given, double amplitude, double frequency, long steps, double dt, double *end) {
    Machine m;
    set_machine(&m, 0, given);
    const Wave command = wave_of(amplitude, frequency);
    const Wave load = wave_of(given->load_amplitude, given->load_frequency);
    Plant x = {0.0, 0.0, given->start_position};
    Valve valve = valve_at(&m, 0.0);
    double force = 0.0;
    for (long k = 0; k < steps; k++) {
        double centre = ((double)k + 0.5) * dt, next = (double)(k + 1) * dt;
        Valve middle = valve_at(&m, wave_at(command, centre)), last = valve_at(&m, wave_at(command, next));
        double load_last = wave_at(load, next);
        x = rk4(&m, x, dt, rates(&m, valve, x, force), middle, wave_at(load, centre), last, load_last);
        valve = last;
        force = load_last;
    }
    end[0] = x.velocity, end[1] = x.force, end[2] = x.position;
}
#endif
