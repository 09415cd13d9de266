/* The closed loop of the paper, written by hand: one function for each law, constants formed once per run.

   Terminal sliding mode control with its observer (boundary layer), a static valve and the load-pressure
   plant; equations of doi:10.1007/s42401-021-00087-w, SI units. The machine may differ from run to run; the
   controller, its nominal model, the demand and the load are those of all runs. */
#include "real.h"

/* What a run is given; the order of its numbers is that of given.py. */
typedef struct {
    double mass, damping, area, volume, bulk_modulus, leakage, start_position;
    double discharge, gradient, density, valve_gain, max_opening, supply;
    double reference_amplitude, reference_frequency, load_amplitude, load_frequency;
    double nominal_mass, nominal_damping, nominal_area, nominal_volume, nominal_bulk_modulus, nominal_leakage;
    double nominal_discharge, nominal_gradient, nominal_density, nominal_supply, nominal_valve_gain, least_drop;
    double mu1, mu2, delta1, delta2, a1, a2, least_xi, limit;
    double kd1, kd2, D1, D2, eps1, eps2, a, phi1, phi2, time_constant;
} Given;

/* dx1/dt = (x2 - b x1 - F)/m,  dx2/dt = -by_velocity x1 - by_force x2 + flow x_v sqrt(drop) */
typedef struct {
    real inv_mass, damping, by_velocity, by_force, flow, inv_area;
    number supply, valve_gain, max_opening;
} Machine;

/* f1 = slope x1,  f2 = -by_velocity x1 - by_force x2,  g2 = gain sqrt(drop) */
typedef struct {
    number slope, g1, by_velocity, by_force, gain, inv_area, supply, least_drop;
} Nominal;

typedef struct {
    number mu1, mu2, delta1, delta2, a1, a2, least_xi, limit;
    number kd1, kd2, D1, D2, eps1, eps2, a, inv_phi1, inv_phi2, weight, dt, inv_dt;
} Law;

/* An amplitude and an angular frequency. */
typedef struct { double amplitude, omega; } Wave;
typedef struct { number value, rate, jerk; } Demand;
typedef struct { real velocity, force, position; } Plant;
/* v1, v2, g2: what the observer predicts for the next sample; rate, last: the filtered derivative of d1. */
typedef struct { real u, v1, v2, g2, rate, last; } Controller;
typedef struct { real d1, d2; } Lumped;
/* The valve under a held command: what multiplies the root, and the opening's sign over the area. */
typedef struct { real push, edge; } Valve;

INLINE real clip(real x, number limit) { return smaller(larger(x, same(-limit)), same(limit)); }
INLINE real signed_power(real x, number a) { return with_sign(power(magnitude(x), same(a)), x); }

INLINE Wave wave_of(double amplitude, double frequency) { return (Wave){amplitude, 2.0 * M_PI * frequency}; }

INLINE double wave_at(Wave w, double t) { return w.amplitude * sin(w.omega * t); }

INLINE Demand demand_at(Wave w, double t) {
    double value = wave_at(w, t);
    double rate = w.amplitude * w.omega * cos(w.omega * t), jerk = -w.omega * w.omega * value;
    return (Demand){(number)value, (number)rate, (number)jerk};
}

/* The machine of one lane's run. */
INLINE void set_machine(Machine *m, int lane, const Given *g) {
#define SET(field, value) ((number *)&m->field)[lane] = (value)
    double stiffness = 4.0 * g->bulk_modulus / g->volume;
    SET(inv_mass, 1.0 / g->mass);
    SET(damping, g->damping);
    SET(by_velocity, stiffness * g->area * g->area);
    SET(by_force, stiffness * g->leakage);
    SET(flow, stiffness * g->area * g->discharge * g->gradient / sqrt(g->density));
    SET(inv_area, 1.0 / g->area);
    m->supply = g->supply;
    m->valve_gain = g->valve_gain;
    m->max_opening = g->max_opening;
}


INLINE Nominal nominal_of(const Given *g) {
    double stiffness = 4.0 * g->nominal_bulk_modulus / g->nominal_volume, area = g->nominal_area;
    double flow = stiffness * area * g->nominal_discharge * g->nominal_gradient / sqrt(g->nominal_density);
    return (Nominal){-g->nominal_damping / g->nominal_mass, 1.0 / g->nominal_mass, stiffness * area * area,
                     stiffness * g->nominal_leakage, flow * g->nominal_valve_gain, 1.0 / area, g->nominal_supply,
                     g->least_drop};
}

INLINE Law law_of(const Given *g, double dt) {
    return (Law){g->mu1, g->mu2, g->delta1, g->delta2, g->a1, g->a2, g->least_xi, g->limit, g->kd1, g->kd2,
                 g->D1, g->D2, g->eps1, g->eps2, g->a, 1.0 / g->phi1, 1.0 / g->phi2,
                 dt / (g->time_constant + dt), dt, 1.0 / dt};
}

INLINE real g2_at(const Nominal *n, real force, real u) {
    return n->gain * root(larger(n->supply - sign(u) * force * n->inv_area, same(n->least_drop)));
}

/* Eqs. (12)-(14) and (19)-(22), the derivative of the estimate d1 from a filtered difference. */
INLINE Lumped control(const Nominal *n, const Law *c, Plant x, Demand r, Controller *s) {
    real f1 = n->slope * x.velocity, f2 = -n->by_velocity * x.velocity - n->by_force * x.force;
    real v2 = s->v2 + c->dt * s->g2 * s->u;
    real s1 = s->v1 - x.velocity, s2 = v2 - x.force;
    real d1 = -c->kd1 * s1 - c->D1 * hyperbolic(s1 * c->inv_phi1) - c->eps1 * signed_power(s1, c->a);
    real d2 = -c->kd2 * s2 - c->D2 * hyperbolic(s2 * c->inv_phi2) - c->eps2 * signed_power(s2, c->a);
    real acceleration = f1 + n->g1 * x.force + d1;
    real g2 = g2_at(n, x.force, s->u);

    real xi1 = x.velocity - r.value + s1, xi1_rate = acceleration - r.rate;
    real xi2 = xi1_rate + c->mu1 * xi1 + c->delta1 * signed_power(xi1, c->a1) + n->g1 * s2 + n->slope * s1;
    real slope = c->a1 * power(magnitude(xi1) + c->least_xi, same(c->a1 - 1));
    real rate = s->rate + c->weight * ((d1 - s->last) * c->inv_dt - s->rate);
    real drift = n->slope * acceleration + n->g1 * (f2 + d2) + rate - r.jerk + c->mu1 * xi1_rate
               + c->delta1 * slope * xi1_rate + c->mu2 * xi2 + c->delta2 * signed_power(xi2, c->a2);
    *s = (Controller){clip(-drift / (n->g1 * g2), c->limit), s->v1 + c->dt * acceleration, v2 + c->dt * (d2 + f2),
                      g2, rate, d1};
    return (Lumped){d1, d2};
}

INLINE Valve valve_at(const Machine *m, real u) {
    real opening = clip(m->valve_gain * u, m->max_opening);
    return (Valve){m->flow * opening, sign(opening) * m->inv_area};
}

INLINE Plant rates(const Machine *m, Valve valve, Plant x, number load) {
    real drop = larger(m->supply - valve.edge * x.force, same(0));
    return (Plant){(x.force - m->damping * x.velocity - load) * m->inv_mass,
                   -m->by_velocity * x.velocity - m->by_force * x.force + valve.push * root(drop), x.velocity};
}

/* What the machine does besides its nominal model, given its rates k: eq. (6). */
INLINE Lumped lumped(const Nominal *n, Plant x, real u, Plant k) {
    return (Lumped){k.velocity - (n->slope * x.velocity + n->g1 * x.force),
                    k.force + n->by_velocity * x.velocity + n->by_force * x.force - g2_at(n, x.force, u) * u};
}

INLINE Plant along(Plant x, number h, Plant k) {
    return (Plant){x.velocity + h * k.velocity, x.force + h * k.force, x.position + h * k.position};
}

/* The classical Runge-Kutta step from the rates k1 at its start, with valve and load at its middle and end. */
INLINE Plant rk4(const Machine *m, Plant x, number h, Plant k1, Valve middle, number load_middle, Valve end,
                 number load_end) {
    Plant k2 = rates(m, middle, along(x, h / 2, k1), load_middle);
    Plant k3 = rates(m, middle, along(x, h / 2, k2), load_middle);
    Plant k4 = rates(m, end, along(x, h, k3), load_end);
    return along(along(along(along(x, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
}
