"""The double-rod cylinder in load-pressure form: eqs. (3)-(5) of the paper."""

from typing import Annotated, NamedTuple

from hydroservo.core.block import Field
from hydroservo.core.roles import Plant, role
from hydroservo.core.signals import MachineOutputs, PortFlows, Pressures
from hydroservo.machine.drives.ports import Ports
from hydroservo.machine.plants.stroke import check_start


class LoadPressureState(NamedTuple):
    """Velocity, load-pressure force and position."""

    velocity: Annotated[float, Field("m/s", "piston velocity x1")]
    hydraulic_force: Annotated[float, Field("N", "load-pressure force x2 = A_p p_L")]
    position: Annotated[float, Field("m", "piston position from the lower end of the stroke")]


@role(Plant)
class LoadPressurePlant(NamedTuple):
    """A symmetric cylinder that moves a mass, described by its load pressure.

    With x1 = dy/dt, x2 = A_p p_L and Q_L the load flow from the valve::

        m  dx1/dt = x2 - b x1 - F_L
           dx2/dt = 4 beta_e A_p/V_t Q_L - 4 beta_e A_p^2/V_t x1 - 4 beta_e C_tl/V_t x2
           dy/dt  = x1

    Source: eqs. (3)-(5) of doi:10.1007/s42401-021-00087-w; Merritt, Hydraulic Control Systems, 1967, ch. 6.
    V_t is the total compressed volume (the print calls it half).
    Fails where the chambers differ (single rod, piston far from mid-stroke), where a chamber
    cavitates, and at the ends of the stroke, which it does not know: leaving it is only reported.
    """

    mass: Annotated[float, Field("kg", "moving mass m", above=0)]
    damping: Annotated[float, Field("N s/m", "viscous damping coefficient b", at_least=0)]
    piston_area: Annotated[float, Field("m^2", "annulus area A_p", above=0)]
    total_volume: Annotated[float, Field("m^3", "total compressed volume V_t", above=0)]
    bulk_modulus: Annotated[float, Field("Pa", "effective bulk modulus beta_e", above=0)]
    leakage: Annotated[float, Field("m^3/(s Pa)", "total leakage coefficient C_tl", at_least=0)]
    stroke: Annotated[float, Field("m", "stroke L_max", above=0)]
    start_position: Annotated[float, Field("m", "piston position at the start", at_least=0)]

    def check(self) -> None:
        check_start(self.start_position, self.stroke)

    def init(self) -> LoadPressureState:
        return LoadPressureState(0.0, 0.0, self.start_position)

    def flows(self, s: LoadPressureState, ports: Ports) -> PortFlows:
        """What the drive passes: the load flow at both ports, and what the line gives and takes [m^3/s]."""
        half, line = 0.5 * self.load_pressure(s), ports.feed.line
        mean = 0.5 * (line.supply + line.tank)
        load = ports.load_flow(self.load_pressure(s))
        passed = ports.flows(mean + half, mean - half)
        return PortFlows(load, load, supply=passed.supply, tank=passed.tank)

    def deriv(self, s: LoadPressureState, flows: PortFlows, force: float) -> LoadPressureState:
        return LoadPressureState(
            velocity=(s.hydraulic_force - self.damping * s.velocity - force) * (1.0 / self.mass),
            hydraulic_force=self.free_force_rate(s.velocity, s.hydraulic_force) + self.flow_gain() * flows.a,
            position=s.velocity,
        )

    def hydraulic_force(self, s: LoadPressureState) -> float:
        """x2 [N]; of a state's rate, its rate."""
        return s.hydraulic_force

    def outputs(self, s: LoadPressureState, line: Pressures, force: float) -> MachineOutputs:
        """What sensors can see; the chambers' pressures lie about the mean of the supply's and the tank's."""
        mean, half = 0.5 * (line.supply + line.tank), 0.5 * self.load_pressure(s)
        return MachineOutputs(s.velocity, s.hydraulic_force, s.position, mean + half, mean - half, force)

    def load_pressure(self, s: LoadPressureState) -> float:
        """p_L [Pa]."""
        return s.hydraulic_force * (1.0 / self.piston_area)

    def free_force_rate(self, velocity: float, hydraulic_force: float) -> float:
        """dx2/dt with the valve closed [N/s]: f2 of eq. (7)."""
        stiffness = 4.0 * self.bulk_modulus / self.total_volume
        return (
            -stiffness * self.piston_area * self.piston_area * velocity
            - stiffness * self.leakage * hydraulic_force
        )

    def flow_gain(self) -> float:
        """dx2/dt per load flow, 4 beta_e A_p/V_t [N/m^3]."""
        return 4.0 * self.bulk_modulus * self.piston_area / self.total_volume

    def simplified(self) -> "LoadPressurePlant":
        """What a design model takes it for: itself."""
        return self
