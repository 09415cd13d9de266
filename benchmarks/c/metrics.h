/* Running metrics, sample by sample: the sums that hydroservo keeps. Squares of the error are integrated over the
   steps, so that the last sample, after which nothing moves, has no weight in them. */

typedef struct {
    real steady_squares;
    real error_squares, error_max, steady_max, command_squares, command_max, command_variation, last_command;
    real settling, overshoot, d1_squares, d2_squares, d1_max, d2_max, miss1_squares, miss2_squares, low, high;
    double samples, last_demand, last_rate, demand_max, jump_time, jump_sign; /* common to all runs */
} Sums;

static inline Sums no_sums(void) {
    Sums s = {};
    s.low = all(HUGE_VAL);
    s.high = all(-HUGE_VAL);
    return s;
}

static inline void measure(Sums *s, double t, double half, int last, Demand r, Plant x, real u, Lumped true,
                           Lumped estimate) {
    double steady = t >= half ? 1.0 : 0.0, lasts = last ? 0.0 : 1.0;
    real error = x.velocity - r.value;
    s->steady_squares += lasts * steady * error * error;
    double started = s->samples > 0.0 ? 1.0 : 0.0, dt = started * t / (s->samples + (1.0 - started));
    double demand_max = fabs(r.value) > s->demand_max ? fabs(r.value) : s->demand_max, band = 0.05 * demand_max;
    double jump = r.value - s->last_demand - 0.5 * dt * (s->last_rate + r.rate);
    if (fabs(jump) - 0.5 * dt * fabs(r.rate - s->last_rate) > band) {
        s->jump_time = t;
        s->jump_sign = copysign(1.0, jump);
    }
    real size = magnitude(error), miss1 = estimate.d1 - true.d1, miss2 = estimate.d2 - true.d2;
    s->error_squares += lasts * error * error;
    s->error_max = larger(lasts * size, s->error_max);
    s->steady_max = larger(lasts * steady * size, s->steady_max);
    s->command_squares += u * u;
    s->command_max = larger(magnitude(u), s->command_max);
    s->command_variation += started * magnitude(u - s->last_command);
    s->last_command = u;
    s->settling = larger(choose(size > band, all(t - s->jump_time), all(0.0)), s->settling);
    s->overshoot = larger(s->jump_sign * error, s->overshoot);
    s->d1_squares += steady * true.d1 * true.d1;
    s->d2_squares += steady * true.d2 * true.d2;
    s->d1_max = larger(magnitude(true.d1), s->d1_max);
    s->d2_max = larger(magnitude(true.d2), s->d2_max);
    s->miss1_squares += steady * miss1 * miss1;
    s->miss2_squares += steady * miss2 * miss2;
    s->low = smaller(x.position, s->low);
    s->high = larger(x.position, s->high);
    s->samples += 1.0;
    s->last_demand = r.value;
    s->last_rate = r.rate;
    s->demand_max = demand_max;
}

/* The metrics of one run from its sums; the order is that of c.py. */
static inline void report(const Sums *sums, int lane, long samples, double *out) {
#define OF(field) (((const double *)&sums->field)[lane])
    double count = (double)samples, steady = (double)(samples - samples / 2), steps = count - 1.0;
    *out++ = sqrt(OF(steady_squares) / (double)((samples - 1) / 2));
    *out++ = sqrt(OF(error_squares) / steps);
    *out++ = OF(error_max);
    *out++ = OF(steady_max);
    *out++ = OF(settling);
    *out++ = OF(overshoot);
    *out++ = sqrt(OF(command_squares) / count);
    *out++ = OF(command_variation);
    *out++ = OF(command_max);
    *out++ = sqrt(OF(miss1_squares) / steady);
    *out++ = sqrt(OF(miss2_squares) / steady);
    *out++ = sqrt(OF(d1_squares) / steady);
    *out++ = sqrt(OF(d2_squares) / steady);
    *out++ = OF(d1_max);
    *out++ = OF(d2_max);
    *out++ = OF(low);
    *out++ = OF(high);
}
