"""Lemmas and closed forms of the field, as pure functions of numbers and trajectories."""

from hydroservo.machine.theory.finite_time import (
    Decrease,
    GainCondition,
    decayed,
    decrease,
    gain_condition,
    settling_bound,
)
from hydroservo.machine.theory.linear import damping_ratio, natural_frequency, proportional_gain_limit

__all__ = [
    "Decrease",
    "GainCondition",
    "damping_ratio",
    "decayed",
    "decrease",
    "gain_condition",
    "natural_frequency",
    "proportional_gain_limit",
    "settling_bound",
]
