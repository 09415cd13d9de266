"""A PI controller in C, written by hand as an export writes one."""

from hydroservo.export.unit import Argument, CModule, Part, Signal
from tests.support.export.by_hand import by_hand

HEADER = """\
/* PI of scenario paper/sine-pi. */
#ifndef TOY_H
#define TOY_H

/* Saturation: u held within +-limit. */
typedef struct {
    double limit; /* [V] largest command */
} toy_saturation;

/* Parameters. */
typedef struct {
    double proportional_gain; /* [V s/m] proportional gain k_p */
    double integral_gain;     /* [V/m] integral gain k_i */
    toy_saturation saturation;
    double period; /* [s] sample period */
} toy_parameters;

typedef struct {
    double u;         /* [V] command */
    double integral;  /* [V] integral part of the command */
    double unlimited; /* [V] command before saturation */
} toy_state;

typedef struct {
    double velocity; /* [m/s] x1, piston velocity */
} toy_measurement;

typedef struct {
    double value; /* [m/s] velocity demand dy_d/dt */
} toy_demand;

extern const toy_parameters toy_defaults;

void toy_init(toy_state *state, const toy_parameters *parameters);
double toy_step(toy_state *state, const toy_parameters *parameters, const toy_measurement *measurement,
                const toy_demand *demand);

#endif
"""

SOURCE = """\
#include "toy.h"
#include <math.h>

const toy_parameters toy_defaults = {
    .proportional_gain = 100.0,
    .integral_gain = 10.0,
    .saturation = {.limit = 10.0},
    .period = 1e-05,
};

static double ops_clip(double x, double low, double high) {
    return (x < low) ? low : ((x > high) ? high : x);
}

static double saturation_apply(const toy_saturation *self, double u) {
    return ops_clip(u, -self->limit, self->limit);
}

void toy_init(toy_state *state, const toy_parameters *parameters) {
    (void)parameters;
    *state = (toy_state){.u = 0.0, .integral = 0.0, .unlimited = 0.0};
}

double toy_step(toy_state *state, const toy_parameters *parameters, const toy_measurement *measurement,
                const toy_demand *demand) {
    const double error = demand->value - measurement->velocity;
    const double integral = state->integral + (parameters->period * (parameters->integral_gain * error));
    const double unlimited = (parameters->proportional_gain * error) + integral;
    *state = (toy_state){
        .u = saturation_apply(&parameters->saturation, unlimited),
        .integral = integral,
        .unlimited = unlimited,
    };
    return state->u;
}
"""


def toy() -> CModule:
    return by_hand(
        "toy",
        "PI of scenario paper/sine-pi",
        1e-5,
        (HEADER, SOURCE),
        parameters=(
            Signal(
                "controller.proportional_gain",
                "proportional_gain",
                "V s/m",
                "proportional gain k_p",
                100.0,
                least=0.0,
                most=1e6,
            ),
            Signal("controller.integral_gain", "integral_gain", "V/m", "integral gain k_i", 10.0),
            Signal("controller.saturation.limit", "saturation.limit", "V", "largest command", 10.0),
            Signal("period", "period", "s", "sample period", 1e-5, fixed=True),
        ),
        arguments=(
            Argument(
                "measurement",
                (Signal("measurement.velocity", "velocity", "m/s", "x1, piston velocity", 0.0),),
            ),
            Argument("demand", (Signal("demand.value", "value", "m/s", "velocity demand dy_d/dt", 0.0),)),
        ),
        states=(
            Signal("controller.u", "u", "V", "command", 0.0),
            Signal("controller.integral", "integral", "V", "integral part of the command", 0.0),
            Signal("controller.unlimited", "unlimited", "V", "command before saturation", 0.0),
        ),
        part=Part.CONTROLLER,
    )
