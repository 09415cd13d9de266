"""A fit and all that it was made of."""

from typing import NamedTuple

from hydroservo.identification.problem import Problem
from hydroservo.identification.search import Solution
from hydroservo.identification.uncertainty import Uncertainty
from hydroservo.scenario.load import Assembly


class Fitted(NamedTuple):
    """What was fitted to what.

    Attributes:
        assembly: the scenario.
        problem: parameters and logs.
        best: where the search ended.
        sure: how sure that is.
    """

    assembly: Assembly
    problem: Problem
    best: Solution
    sure: Uncertainty
