/* An axis under position control, written by hand: a single-rod cylinder with air in its oil and LuGre friction, on a
   valve of second order with overlap and hysteresis; a PID with feedforward behind a compensation of the overlap, whose
   command comes half a period late. SI units. LANES runs in a vector (one at a time if LANES is 1), GROUPS of
   vectors together. Built with -DLANES=1, 4 or 8 and -DGROUPS=... */
#include "real.h"

#define WIDTH (LANES * GROUPS)
#define ATMOSPHERE 101325.0

/* What a run is given; the order of its numbers is that of AXIS in given.py. */
#define NUMBERS(X)                                                                                                     \
    X(mass) X(area_a) X(area_b) X(stroke) X(dead_a) X(dead_b) X(leakage) X(position) X(pressure_a) X(pressure_b)      \
    X(liquid) X(air) X(index) X(bristles) X(bending) X(coulomb) X(breakaway) X(slip) X(viscous) X(contact) X(loss)    \
    X(gain) X(omega) X(zeta) X(travel) X(slew) X(hysteresis) X(discharge) X(gradient) X(density) X(lap) X(clearance)  \
    X(transition) X(ratio_b) X(supply) X(tank) X(delay) X(from) X(to) X(speed) X(begin) X(load) X(load_time)          \
    X(kp) X(ki) X(kv) X(windup) X(integral_limit) X(limit) X(extend) X(retract) X(threshold)

#define FIELD(name) double name;
typedef struct { NUMBERS(FIELD) } Given;
#undef FIELD
#define FIELD(name) real name;
/* A Given for each lane, and what is formed of it once. */
typedef struct { NUMBERS(FIELD) real inv_mass, edge, inv_index, share, inv_slip, brake; } Axis;
#undef FIELD

typedef struct { real v, x, a, b, z, spool, rate; } State;
typedef struct { real u, before, integral, unlimited, added; } Controller;
typedef struct {
    real squares, largest, steady_squares, steady_largest, last, low, high, lowest, highest, torn;
    real command_squares, command_largest, variation, last_command;
    real start, demand_max, jump_time, jump_sign, settling, overshoot;
    double last_demand, last_rate, last_step;
} Sums;
typedef struct { Axis m; State s; Controller c; Sums sums; } Runs;
typedef struct { double value, rate; } Demand;

INLINE real bound(real x, real low, real high) { return smaller(larger(x, low), high); }

static void form(Axis *m) {
    m->inv_mass = 1.0 / m->mass;
    m->edge = m->discharge * m->gradient * root(2.0 / m->density);
    m->inv_index = 1.0 / m->index;
    m->share = m->air / ((1.0 - m->air) * m->liquid);
    m->inv_slip = 1.0 / m->slip;
    m->brake = 5.0 * m->omega;
}

INLINE real modulus(const Axis *m, real pressure) {
    real absolute = larger(pressure + ATMOSPHERE, same(1e-3));
    real liquid = m->liquid + (absolute - ATMOSPHERE), gas = m->index * absolute;
    real ratio = m->share * power(ATMOSPHERE / absolute, m->inv_index) * liquid;
    return (1.0 + ratio) * liquid * gas / (gas + ratio * liquid);
}

INLINE real through(const Axis *m, real drop) {
    return drop / root(root(drop * drop + m->transition * m->transition));
}

INLINE real uncovered(const Axis *m, real opening) {
    real z = opening - m->lap;
    return 0.5 * (z + root(z * z + 4.0 * m->clearance * m->clearance));
}

INLINE State rates(const Axis *m, State s, real u, double force) {
    const real zero = same(0.0), one = same(1.0);
    real out = m->edge * uncovered(m, s.spool), back = m->edge * uncovered(m, -s.spool);
    real into_a = out * through(m, m->supply - s.a) - back * through(m, s.a - m->tank);
    real out_of_b = m->ratio_b * (out * through(m, s.b - m->tank) - back * through(m, m->supply - s.b));
    real below = larger(-s.x, zero), above = larger(s.x - m->stroke, zero);
    real stops = m->contact * (below * larger(one - m->loss * s.v, zero) - above * larger(one + m->loss * s.v, zero));
    real slip = s.v * m->inv_slip, sliding = m->coulomb + (m->breakaway - m->coulomb) * exponential(-(slip * slip));
    real pull = m->bristles * s.z, bending = s.v - magnitude(s.v) * pull / sliding;
    real friction = pull + m->bending * bending + m->viscous * s.v;
    real past = m->leakage * (s.a - s.b);
    real volume_a = larger(m->dead_a + m->area_a * s.x, 0.01 * m->dead_a);
    real volume_b = larger(m->dead_b + m->area_b * (m->stroke - s.x), 0.01 * m->dead_b);
    real commanded = bound(m->gain * u, -m->travel, m->travel), play = 0.5 * m->hysteresis;
    real target = bound(s.spool, commanded - play, commanded + play);
    real free = m->omega * (m->omega * (target - s.spool) - 2.0 * m->zeta * s.rate);
    real most = m->brake * smaller(m->slew - s.rate, m->brake * (m->travel - s.spool) - 2.0 * s.rate);
    real least = -m->brake * smaller(m->slew + s.rate, m->brake * (m->travel + s.spool) + 2.0 * s.rate);
    return (State){
        (m->area_a * s.a - m->area_b * s.b - force + stops - friction) * m->inv_mass,
        s.v,
        modulus(m, s.a) / volume_a * (into_a - past - m->area_a * s.v),
        modulus(m, s.b) / volume_b * (past - out_of_b + m->area_b * s.v),
        bending,
        s.rate,
        bound(free, least, most),
    };
}

INLINE State ahead(State s, double h, State k) {
    return (State){s.v + h * k.v, s.x + h * k.x, s.a + h * k.a, s.b + h * k.b, s.z + h * k.z, s.spool + h * k.spool,
                   s.rate + h * k.rate};
}

INLINE State rk4(const Axis *m, State s, double h, real u, double force) {
    State k1 = rates(m, s, u, force), k2 = rates(m, ahead(s, 0.5 * h, k1), u, force);
    State k3 = rates(m, ahead(s, 0.5 * h, k2), u, force), k4 = rates(m, ahead(s, h, k3), u, force);
    return ahead(ahead(ahead(ahead(s, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
}

INLINE void control(const Axis *m, State s, Demand r, double dt, double late, Controller *c) {
    const real zero = same(0.0), one = same(1.0);
    real applied = late * c->before + (1.0 - late) * c->u - c->added, error = r.value - s.x;
    c->integral += dt * (m->ki * error + m->windup * (applied - c->unlimited));
    c->integral = bound(c->integral, -m->integral_limit, m->integral_limit);
    c->unlimited = m->kp * error + c->integral + m->kv * r.rate;
    real law = bound(c->unlimited, -m->limit, m->limit);
    c->added = choose(law > zero, m->extend, m->retract) * bound(law / m->threshold, -one, one);
    c->before = c->u;
    c->u = bound(law + c->added, -m->limit, m->limit);
}

INLINE void measure(Sums *s, double t, double step, double half, Demand r, State x) {
    const real zero = same(0.0);
    int first = s->last_step == 0.0, steady = t >= half;
    real error = x.x - r.value, squares = error * error * step, size = magnitude(error);
    s->largest = larger(s->last, s->largest);
    if (steady) s->steady_squares += squares;
    if (t > half) s->steady_largest = larger(s->last, s->steady_largest);
    s->squares += squares;
    s->last = size;
    if (first) s->start = x.x;
    s->demand_max = larger(s->demand_max, magnitude(r.value - s->start));
    real band = 0.05 * s->demand_max, before = first ? s->start : same(s->last_demand);
    real jump = r.value - before - 0.5 * s->last_step * (s->last_rate + r.rate);
    mask jumped = magnitude(jump) - 0.5 * s->last_step * fabs(r.rate - s->last_rate) > band;
    s->jump_time = choose(jumped, same(t), s->jump_time);
    s->jump_sign = choose(jumped, sign(jump), s->jump_sign);
    s->settling = larger(choose(size > band, t - s->jump_time, zero), s->settling);
    s->overshoot = larger(s->jump_sign * error, s->overshoot);
    s->last_demand = r.value;
    s->last_rate = r.rate;
    s->last_step = step;
    s->low = smaller(x.x, s->low);
    s->high = larger(x.x, s->high);
    real low = smaller(x.a, x.b);
    s->lowest = smaller(low, s->lowest);
    s->highest = larger(larger(x.a, x.b), s->highest);
    s->torn += choose(low < zero, same(step), zero);
}

INLINE Demand demand_at(const Given *g, double t) {
    double change = g->to - g->from, gained = g->speed * fmax(t - g->begin, 0.0);
    int started = t >= (1.0 - 1e-9) * g->begin, ended = gained >= (1.0 - 1e-9) * fabs(change);
    if (!started) return (Demand){g->from, 0.0};
    if (ended) return (Demand){g->to, 0.0};
    return (Demand){g->from + copysign(gained, change), copysign(g->speed, change)};
}

static void report(const Sums *sums, int lane, long periods, double duration, double half, double *out) {
#define OF(field) (((const double *)&sums->field)[lane])
    *out++ = sqrt(OF(squares) / duration);
    *out++ = OF(largest);
    *out++ = sqrt(OF(steady_squares) / (duration - half));
    *out++ = OF(steady_largest);
    *out++ = OF(settling);
    *out++ = OF(overshoot);
    *out++ = sqrt(OF(command_squares) / (double)(periods + 1));
    *out++ = OF(variation);
    *out++ = OF(command_largest);
    *out++ = OF(low);
    *out++ = OF(high);
    *out++ = OF(lowest);
    *out++ = OF(highest);
    *out++ = OF(torn);
}

static void together(const Given *given, long count, long periods, double dt, long substeps, double *out,
                     long metrics) {
    Runs runs[GROUPS] = {};
    for (long i = 0; i < WIDTH; i++) { /* lanes beyond the last run repeat it */
        const double *numbers = (const double *)(given + (i < count ? i : count - 1));
        double *lanes = (double *)&runs[i / LANES].m;
        for (unsigned long n = 0; n < sizeof(Given) / sizeof(double); n++)
            lanes[n * LANES + (unsigned long)(i % LANES)] = numbers[n];
    }
    for (int g = 0; g < GROUPS; g++) {
        form(&runs[g].m);
        runs[g].s.x = runs[g].m.position, runs[g].s.a = runs[g].m.pressure_a, runs[g].s.b = runs[g].m.pressure_b;
        runs[g].sums.low = runs[g].sums.lowest = same(HUGE_VAL);
        runs[g].sums.high = runs[g].sums.highest = same(-HUGE_VAL);
    }
    const double h = dt / (double)substeps, duration = (double)periods * dt, half = 0.5 * duration;
    const long late = lround(given->delay / h);
    for (long k = 0; k <= periods; k++) {
        const double t = (double)k * dt, force = t >= (1.0 - 1e-9) * given->load_time ? given->load : 0.0;
        const Demand r = demand_at(given, t);
        for (int g = 0; g < GROUPS; g++) {
            Controller *c = &runs[g].c;
            Sums *s = &runs[g].sums;
            control(&runs[g].m, runs[g].s, r, dt, given->delay / dt, c);
            s->command_squares += c->u * c->u;
            s->command_largest = larger(magnitude(c->u), s->command_largest);
            if (k > 0) s->variation += magnitude(c->u - s->last_command);
            s->last_command = c->u;
        }
        for (long i = 0; i < (k < periods ? substeps : 1); i++) {
            const double instant = t + (double)i * h, step = k < periods ? h : 0.0;
            const Demand now = demand_at(given, instant);
            for (int g = 0; g < GROUPS; g++) {
                measure(&runs[g].sums, instant, step, half, now, runs[g].s);
                real u = i < late ? runs[g].c.before : runs[g].c.u;
                if (k < periods) runs[g].s = rk4(&runs[g].m, runs[g].s, h, u, force);
            }
        }
    }
    for (long i = 0; i < WIDTH && i < count; i++)
        report(&runs[i / LANES].sums, (int)(i % LANES), periods, duration, half, out + i * metrics);
}

void axis(const Given *given, long count, long periods, double dt, long substeps, int threads, double *out,
          long metrics) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (long i = 0; i < count; i += WIDTH)
        together(given + i, count - i, periods, dt, substeps, out + i * metrics, metrics);
}
