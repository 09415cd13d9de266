"""How the machine is carried from one sample to the next."""

from hydroservo.machine.integrators.rk4 import RK4
from hydroservo.machine.integrators.rosenbrock import Rosenbrock
from hydroservo.machine.integrators.tsit5 import Tsit5

__all__ = ["RK4", "Rosenbrock", "Tsit5"]
