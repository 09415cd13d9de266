"""Lemmas and closed forms of the field, as pure functions of numbers and trajectories."""

from hydroservo.machine.theory.decrease import Decrease, decrease
from hydroservo.machine.theory.finite_time import decayed, settling_bound
from hydroservo.machine.theory.gain_condition import GainCondition, gain_condition
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
