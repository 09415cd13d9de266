"""Lemmas and closed forms of the field, as pure functions of numbers and trajectories."""

from hydroservo.theory.decrease import Decrease, decrease
from hydroservo.theory.finite_time import decayed, settling_bound
from hydroservo.theory.gain_condition import GainCondition, gain_condition
from hydroservo.theory.linear import damping_ratio, natural_frequency, proportional_gain_limit

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
