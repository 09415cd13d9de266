"""A pump between the cylinder's ports, turned by a servo motor."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Field
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import CheckFlow, Drive, Relief, role, valveless
from hydroservo.core.signals import Feed, PortFlows
from hydroservo.core.sources import DATASHEET

Displacement = Annotated[float, Field("m^3/rad", "displacement D of the pump", above=0)]
MaxSpeed = Annotated[float, Field("rad/s", "largest speed w_max that is demanded", above=0)]
SpeedGain = Annotated[float, Field("N m s/rad", "gain K of the speed control", above=0)]
MaxTorque = Annotated[float, Field("N m", "largest torque T_max of the motor", above=0)]
Inertia = Annotated[float, Field("kg m^2", "inertia J of motor and pump", above=0)]
Viscous = Annotated[float, Field("N m s/rad", "viscous friction B of both", "0: none", at_least=0)]
CaseLeakage = Annotated[
    float, Field("m^3/(s Pa)", "leakage L_c from each port to the case", "0: none", at_least=0)
]

DisplacementRatio = Annotated[
    float, Field("", "ratio r of the displacement at port B to that at port A", "one pump", above=0)
]


class PumpDriveState(NamedTuple):
    """The shaft's speed."""

    speed: Annotated[float, Field("rad/s", "speed w of the shaft; above 0 it pumps out of port A")]


@valveless
@role(Drive)
class PumpDrive(NamedTuple):
    """A speed-controlled motor turns a fixed-displacement pump between the two ports: no valve meters.

    At port B the displacement may be another one, r D, of a second pump on the shaft; the tank's line takes
    and gives the difference. With the shaft's speed w, the command u, the pressures p_A and p_B at the ports,
    p_P in the loop's supply line, which replenishes, and p_T in the tank's line, into which the case drains::

        J dw/dt = T - D (p_A - p_T) + r D (p_B - p_T) - B w
        T       = K (w_ref - w) within +-T_max          w_ref = k u within +-w_max
        Q_A     = D w - L (p_A - p_B) - L_c (p_A - p_T) + Q_PA
        Q_B     = r D w - L (p_A - p_B) + L_c (p_B - p_T) - Q_PB

    Q_A flows into chamber A, Q_B out of chamber B. Q_PA and Q_PB come from the supply's line through the
    check valves, which the pressure at the other port pilots, less what the relief valves let off into it;
    their cracking pressure is that above the line's. Its power is that of the line's oil and T w at the
    shaft; while the load turns it, T w is negative.

    A single rod's chambers differ in what they take. Two pumps in proportion to its areas leave nothing over.
    With one pump, the check valve at the rod's side feeds the rest on the way out; on the way in, a pilot
    must open the one at the piston's side for it, or a relief valve lets it off. The motor has no integral
    action: a pressure rise costs it the speed D (p_A - p_B)/(K + B), with r = 1.

    Source: Merritt, Hydraulic Control Systems, 1967 (pump-controlled motor, with replenishing and relief
    valves).
    Fails where the flow pulsates with the pump's pistons, and where friction in the pump grows with pressure;
    of a cylinder described by its load pressure it does not know what replenishes it.
    """

    displacement: Displacement
    command_gain: Annotated[float, Field("rad/(s V)", "speed k demanded per command", above=0)]
    max_speed: MaxSpeed
    speed_gain: SpeedGain
    max_torque: MaxTorque
    inertia: Inertia
    check_valve: CheckFlow
    relief: Relief
    viscous: Viscous = 0.0
    leakage: Annotated[float, Field("m^3/(s Pa)", "leakage L between the ports", "0: none", at_least=0)] = 0.0
    case_leakage: CaseLeakage = 0.0
    displacement_ratio: DisplacementRatio = 1.0

    @classmethod
    def from_datasheet(
        cls,
        displacement: Displacement,
        max_speed: MaxSpeed,
        max_command: Annotated[float, Field("V", "command at the largest speed", above=0)],
        rated_speed: Annotated[float, Field("rad/s", "speed at the rated point", DATASHEET, above=0)],
        rated_pressure: Annotated[float, Field("Pa", "pressure rise when rated", DATASHEET, above=0)],
        volumetric_efficiency: Annotated[
            float, Field("", "volumetric efficiency at the rated point", DATASHEET, above=0, at_most=1)
        ],
        speed_gain: SpeedGain,
        max_torque: MaxTorque,
        inertia: Inertia,
        check_valve: CheckFlow,
        relief: Relief,
        viscous: Viscous = 0.0,
        case_leakage: CaseLeakage = 0.0,
        displacement_ratio: DisplacementRatio = 1.0,
    ) -> "PumpDrive":
        """The drive whose pump delivers eta D w_n at its rated speed w_n, against p_n.

        The rest leaks, L + L_c = (1 - eta) D w_n/p_n, that to the case among it. The largest command
        demands the largest speed: k = w_max/u_max.

        Raises:
            ParameterError: max_command, rated_speed, rated_pressure or volumetric_efficiency is not above 0,
                the efficiency is above 1, the motor's largest torque does not hold the rated point, or more
                leaks to the case than the efficiency says.
        """
        given = {
            "max_command": max_command,
            "rated_speed": rated_speed,
            "rated_pressure": rated_pressure,
            "volumetric_efficiency": volumetric_efficiency,
        }
        for name, value in given.items():
            if not value > 0.0:
                raise ParameterError(name, value, "must be above 0")
        if not volumetric_efficiency <= 1.0:
            raise ParameterError("volumetric_efficiency", volumetric_efficiency, "must be at most 1")
        torque = displacement * rated_pressure + viscous * rated_speed
        if not torque <= max_torque:
            allowed = f"must be at least {torque:.4g} [N m], as the rated speed and pressure need"
            raise ParameterError("max_torque", max_torque, allowed)
        lost = (1.0 - volumetric_efficiency) * displacement * rated_speed / rated_pressure
        if not case_leakage <= lost:
            allowed = f"must be at most {lost:.4g} [m^3/(s Pa)], all that leaks at this efficiency"
            raise ParameterError("case_leakage", case_leakage, allowed)
        return cls(
            displacement=displacement,
            command_gain=max_speed / max_command,
            max_speed=max_speed,
            speed_gain=speed_gain,
            max_torque=max_torque,
            inertia=inertia,
            check_valve=check_valve,
            relief=relief,
            viscous=viscous,
            leakage=lost - case_leakage,
            case_leakage=case_leakage,
            displacement_ratio=displacement_ratio,
        )

    def init(self) -> PumpDriveState:
        return PumpDriveState(0.0)

    def deriv(self, s: PumpDriveState, feed: Feed, pressure_a: float, pressure_b: float) -> PumpDriveState:
        rest = (1.0 - self.displacement_ratio) * feed.line.tank
        load = self.displacement * (pressure_a - self.displacement_ratio * pressure_b - rest)
        torque = self.torque(s, feed)
        return PumpDriveState((torque - load - self.viscous * s.speed) * (1.0 / self.inertia))

    def flows(self, s: PumpDriveState, feed: Feed, pressure_a: float, pressure_b: float) -> PortFlows:
        swept, leaked = self.displacement * s.speed, self.leakage * (pressure_a - pressure_b)
        pumped_a, pumped_b = swept - leaked, self.displacement_ratio * swept - leaked
        case_a = self.case_leakage * (pressure_a - feed.line.tank)
        case_b = self.case_leakage * (pressure_b - feed.line.tank)
        fed_a = self.replenished(feed.line.supply, pressure_a, pressure_b)
        fed_b = self.replenished(feed.line.supply, pressure_b, pressure_a)
        return PortFlows(
            pumped_a - case_a + fed_a,
            pumped_b + case_b - fed_b,
            supply=fed_a + fed_b,
            tank=case_a + case_b + (self.displacement_ratio - 1.0) * swept,
        )

    def load_flow(self, s: PumpDriveState, feed: Feed, load_pressure: float) -> float:
        mean = 0.5 * (1.0 + self.displacement_ratio)
        return mean * self.displacement * s.speed - (self.leakage + 0.5 * self.case_leakage) * load_pressure

    def power(
        self, s: PumpDriveState, feed: Feed, flows: PortFlows, pressure_a: float, pressure_b: float
    ) -> float:
        return feed.line.supply * flows.supply + self.torque(s, feed) * s.speed

    def torque(self, s: PumpDriveState, feed: Feed) -> float:
        """Of the motor [N m]."""
        demanded = ops.clip(self.command_gain * feed.command, -self.max_speed, self.max_speed)
        return ops.clip(self.speed_gain * (demanded - s.speed), -self.max_torque, self.max_torque)

    def replenished(self, supply: float, pressure: float, pilot: float) -> float:
        """What a port gets from the supply's line, less what its relief valve lets off into it [m^3/s]."""
        let_in = self.check_valve.piloted(supply - pressure, pilot - supply)
        return let_in - self.relief.flow(pressure - supply)
