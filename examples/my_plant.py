"""A plant in a file of its own: copy it, change the machine, run it.

In Python: ``replace(loop, {"plant": Hoist(mass=40.0, drum_radius=0.08, displacement=8e-6)})``.
From a scenario: ``hydroservo run my_plant.toml --plugin my_plant.py``.
"""

from typing import Annotated, NamedTuple

from hydroservo import Field, ParameterError
from hydroservo.core.roles import Plant, role
from hydroservo.core.signals import MachineOutputs, PortFlows, Pressures
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.plants import LoadPressurePlant


class HoistState(NamedTuple):
    """What is integrated."""

    velocity: Annotated[float, Field("m/s", "velocity of the rope, upwards")]
    position: Annotated[float, Field("m", "height of the load")]
    pressure_a: Annotated[float, Field("Pa", "pressure p_A at the motor's port A")]
    pressure_b: Annotated[float, Field("Pa", "pressure p_B at the motor's port B")]


@role(Plant)
class Hoist(NamedTuple):
    """A hydraulic motor turns a drum, and a rope on it lifts a mass: a rotary axis, seen at its rope.

    With the drum's radius r, the motor's displacement D per radian, a = D/r and the valve's flows Q_A, Q_B::

        (m + J/r^2) dv/dt = a (p_A - p_B) - m g - b v - F_L
                    dx/dt = v
                  dp_A/dt = beta_e/V (Q_A - a v - C_i (p_A - p_B))
                  dp_B/dt = beta_e/V (a v - Q_B + C_i (p_A - p_B))

    Source: Merritt, Hydraulic Control Systems, 1967, ch. 6; the numbers are of a small hoist, made up.
    Fails where the rope goes slack, where a port cavitates, and at the ends of the rope.
    """

    mass: Annotated[float, Field("kg", "mass m on the rope", "example", above=0)] = 40.0
    inertia: Annotated[float, Field("kg m^2", "inertia J of the drum", "example", at_least=0)] = 0.05
    damping: Annotated[float, Field("N s/m", "friction b at the rope", "example", at_least=0)] = 500.0
    drum_radius: Annotated[float, Field("m", "radius r of the drum", "example", above=0)] = 0.08
    displacement: Annotated[float, Field("m^3/rad", "displacement D", "example", above=0)] = 8e-6
    line_volume: Annotated[float, Field("m^3", "volume V of each line", "example", above=0)] = 2e-5
    bulk_modulus: Annotated[float, Field("Pa", "bulk modulus beta_e", "example", above=0)] = 1e9
    leakage: Annotated[float, Field("m^3/(s Pa)", "leakage C_i", "example", at_least=0)] = 1e-13
    gravity: Annotated[float, Field("m/s^2", "gravity g", "standard", at_least=0)] = 9.80665
    stroke: Annotated[float, Field("m", "length of rope to wind", "example", above=0)] = 2.0
    start_position: Annotated[float, Field("m", "height at the start", "example", at_least=0)] = 0.5
    start_pressure_a: Annotated[float, Field("Pa", "p_A at the start", "at rest", derived=True)] = 0.0
    start_pressure_b: Annotated[float, Field("Pa", "p_B at the start", "at rest", derived=True)] = 0.0

    def check(self) -> None:
        if self.start_position > self.stroke:
            raise ParameterError("start_position", self.start_position, f"at most {self.stroke:g} [m]")

    def at_rest(self, line: Pressures, force: float) -> "Hoist":
        drop = (self.mass * self.gravity + force) / self.area()
        if abs(drop) > line.supply - line.tank:
            allowed = f"asks the motor for {drop:.4g} [Pa]; the supply has {line.supply - line.tank:.4g}"
            raise ParameterError("mass", self.mass, allowed)
        mean = 0.5 * (line.supply + line.tank)
        return self._replace(start_pressure_a=mean + 0.5 * drop, start_pressure_b=mean - 0.5 * drop)

    def init(self) -> HoistState:
        return HoistState(0.0, self.start_position, self.start_pressure_a, self.start_pressure_b)

    def flows(self, s: HoistState, ports: Ports) -> PortFlows:
        return ports.flows(s.pressure_a, s.pressure_b)

    def deriv(self, s: HoistState, flows: PortFlows, force: float) -> HoistState:
        resistance = self.mass * self.gravity + self.damping * s.velocity + force
        taken = self.area() * s.velocity + self.leakage * (s.pressure_a - s.pressure_b)
        stiffness = self.bulk_modulus / self.line_volume
        return HoistState(
            velocity=(self.hydraulic_force(s) - resistance) / self.moving_mass(),
            position=s.velocity,
            pressure_a=stiffness * (flows.a - taken),
            pressure_b=stiffness * (taken - flows.b),
        )

    def hydraulic_force(self, s: HoistState) -> float:
        return self.area() * (s.pressure_a - s.pressure_b)

    def outputs(self, s: HoistState, line: Pressures, force: float) -> MachineOutputs:
        met = self.mass * self.gravity + force
        return MachineOutputs(
            s.velocity, self.hydraulic_force(s), s.position, s.pressure_a, s.pressure_b, met
        )

    def simplified(self) -> LoadPressurePlant:
        return LoadPressurePlant(
            mass=self.moving_mass(),
            damping=self.damping,
            piston_area=self.area(),
            total_volume=2.0 * self.line_volume,
            bulk_modulus=self.bulk_modulus,
            leakage=self.leakage,
            stroke=self.stroke,
            start_position=self.start_position,
        )

    def area(self) -> float:
        """What a piston's area is to a cylinder: oil per length of rope [m^2]."""
        return self.displacement / self.drum_radius

    def moving_mass(self) -> float:
        """All that moves, as felt at the rope [kg]."""
        return self.mass + self.inertia / (self.drum_radius * self.drum_radius)
