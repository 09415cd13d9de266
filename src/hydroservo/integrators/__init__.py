"""How the machine is carried from one sample to the next."""

from hydroservo.integrators.rk4 import RK4
from hydroservo.integrators.rosenbrock import Rosenbrock
from hydroservo.integrators.tsit5 import Tsit5

__all__ = [
    "RK4",
    "Rosenbrock",
    "Tsit5",
]
