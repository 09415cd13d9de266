/* Running metrics, sample by sample: the sums that hydroservo keeps. Squares of the error are integrated over the
   steps, so that the last sample, after which nothing moves, has no weight in them. */

typedef struct {
    real steady_squares;
    real error_squares, error_max, steady_max, command_squares, command_max, command_variation, last_command;
    real settling, overshoot, d1_squares, d2_squares, d1_max, d2_max, miss1_squares, miss2_squares, low, high;
    number samples, last_demand, last_rate, demand_max, jump_time, jump_sign; /* common to all runs */
} Sums;

INLINE Sums no_sums(void) {
    Sums s = {};
    s.low = same(HUGE_VAL);
    s.high = same(-HUGE_VAL);
    return s;
}

INLINE void measure(Sums *s, double t, double half, int last, Demand r, Plant x, real u, Lumped actual,
                    Lumped estimate) {
    number steady = t >= half, lasts = !last;
    real error = x.velocity - r.value;
    s->steady_squares += lasts * steady * error * error;
    number started = s->samples > 0, now = t, dt = started * now / (s->samples + (1 - started));
    number demand_max = fabs(r.value) > s->demand_max ? fabs(r.value) : s->demand_max;
    number band = (number)0.05 * demand_max, jump = r.value - s->last_demand - dt / 2 * (s->last_rate + r.rate);
    if (fabs(jump) - dt / 2 * fabs(r.rate - s->last_rate) > band) {
        s->jump_time = now;
        s->jump_sign = copysign((number)1, jump);
    }
    real size = magnitude(error), miss1 = estimate.d1 - actual.d1, miss2 = estimate.d2 - actual.d2;
    s->error_squares += lasts * error * error;
    s->error_max = larger(lasts * size, s->error_max);
    s->steady_max = larger(lasts * steady * size, s->steady_max);
    s->command_squares += u * u;
    s->command_max = larger(magnitude(u), s->command_max);
    s->command_variation += started * magnitude(u - s->last_command);
    s->last_command = u;
    s->settling = larger(choose(size > band, same(now - s->jump_time), same(0)), s->settling);
    s->overshoot = larger(s->jump_sign * error, s->overshoot);
    s->d1_squares += steady * actual.d1 * actual.d1;
    s->d2_squares += steady * actual.d2 * actual.d2;
    s->d1_max = larger(magnitude(actual.d1), s->d1_max);
    s->d2_max = larger(magnitude(actual.d2), s->d2_max);
    s->miss1_squares += steady * miss1 * miss1;
    s->miss2_squares += steady * miss2 * miss2;
    s->low = smaller(x.position, s->low);
    s->high = larger(x.position, s->high);
    s->samples += 1;
    s->last_demand = r.value;
    s->last_rate = r.rate;
    s->demand_max = demand_max;
}

/* The metrics of one run from its sums; the order is that of c.py. */
INLINE void report(const Sums *sums, int lane, long samples, double *out) {
#define OF(field) (((const number *)&sums->field)[lane])
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
