"""The paper's lemmas and the field's closed forms, as pure functions of numbers and trajectories."""

from hydroservo.theory.decrease import Decrease, condition_17, condition_25, decrease
from hydroservo.theory.finite_time import decayed, settling_bound
from hydroservo.theory.gain_condition import GainCondition, gain_condition, lemma_2
from hydroservo.theory.linear import damping_ratio, natural_frequency, proportional_gain_limit

__all__ = [
    "Decrease",
    "GainCondition",
    "condition_17",
    "condition_25",
    "damping_ratio",
    "decayed",
    "decrease",
    "gain_condition",
    "lemma_2",
    "natural_frequency",
    "proportional_gain_limit",
    "settling_bound",
]
