"""A pump on a servo motor, with relief valve, line and accumulator."""

from typing import Annotated, NamedTuple

from hydroservo.core import ops
from hydroservo.core.block import Block, Field
from hydroservo.core.constants import ATMOSPHERE
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import quantity
from hydroservo.core.roles import Accumulator, Poppet, Supply, role
from hydroservo.core.signals import Pressures
from hydroservo.core.sources import CHOSEN, DATASHEET
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.supplies.instant_poppet import InstantPoppet, InstantPoppetState
from hydroservo.machine.supplies.no_accumulator import NoAccumulator
from hydroservo.machine.supplies.relief import ReliefValve

MOST_OVERRIDE = 0.5  # beyond cracking, as a share of it, at which a relief valve fits its pump
LEAST_PRESSURE = 1.0  # [Pa] absolute, at which the air is thought to grow no more
NONE, INSTANT = NoAccumulator(), InstantPoppet()

Displacement = Annotated[float, Field("m^3/rad", "displacement of the pump", above=0)]
RatedSpeed = Annotated[float, Field("rad/s", "speed at the rated point", DATASHEET, above=0)]
RatedPressure = Annotated[float, Field("Pa", "pressure rise over the pump when rated", DATASHEET, above=0)]
VolumetricEfficiency = Annotated[
    float, Field("", "volumetric efficiency at the rated point", DATASHEET, above=0, at_most=1)
]
SpeedGain = Annotated[float, Field("N m s/rad", "gain of the speed control", above=0)]
MaxTorque = Annotated[float, Field("N m", "largest torque of the motor", above=0)]
Inertia = Annotated[float, Field("kg m^2", "inertia of motor and pump", above=0)]
ViscousFriction = Annotated[float, Field("N m s/rad", "viscous friction of both", "0: none", at_least=0)]
ReturnPressure = Annotated[float, Field("Pa", "return pressure p_r", "an open tank", above=-ATMOSPHERE)]
Volume = Annotated[float, Field("m^3", "oil between pump and valve", above=0)]
BulkModulus = Annotated[float, Field("Pa", "bulk modulus of oil and line", above=0)]
FreeAir = Annotated[
    float, Field("", "free air at atmospheric pressure, as a share of the volume", CHOSEN, above=0, below=1)
]


class PumpSupplyState(NamedTuple):
    """The shaft's speed, the line's pressure and how far the relief valve is open."""

    speed: Annotated[float, Field("rad/s", "speed of the shaft")]
    pressure: Annotated[float, Field("Pa", "pressure in the supply line")]
    poppet: Block = InstantPoppetState()


@role(Supply)
class PumpSupply(NamedTuple):
    """A fixed-displacement pump turned by a speed-controlled motor, feeding a line with a relief valve.

    With the shaft's speed w, the line's pressure p, its absolute value p_abs = p + p_0 with p_0 = 101325 Pa,
    the return pressure p_r, the pump's displacement D, the flow Q_relief of the relief valve,
    whose poppet may take its time, and the flow Q drawn by the servo valve::

        J dw/dt = T - D (p - p_r) - B w      T = K (w_ref - w) within +-T_max
        C dp/dt = D w - L (p - p_r) - Q_relief - Q
        C       = V (1/beta_e + a p_0/p_abs^2) + C_accumulator(p)

    The free air a is what keeps p above -p_0 however much is drawn: the line then fills with it. The
    motor has no integral action, so the load D (p - p_r) costs it the speed D (p - p_r)/(K + B). All starts
    steady with the valve shut, at the pressure where the relief valve takes what the pump delivers. Without
    a demanded speed the accumulator is alone: ``start.given.supply.pressure`` says to what it is charged.

    Source: Merritt, Hydraulic Control Systems, 1967 (pumps, continuity of a compressed volume).
    Fails where the flow pulsates with the pump's pistons, where the line is long enough for waves, and where
    the pump cannot suck: its losses are proportional to pressure and speed here.
    """

    displacement: Displacement
    demanded_speed: Annotated[float, Field("rad/s", "demanded speed", at_least=0)]
    max_torque: MaxTorque
    inertia: Inertia
    volume: Volume
    bulk_modulus: BulkModulus
    relief: ReliefValve
    speed_gain: SpeedGain
    viscous: ViscousFriction = 0.0
    leakage: Annotated[float, Field("m^3/(s Pa)", "leakage of the pump", "0: none", at_least=0)] = 0.0
    return_pressure: ReturnPressure = 0.0
    free_air: FreeAir = 5e-3
    accumulator: Accumulator = NONE
    poppet: Poppet = INSTANT

    @classmethod
    def from_datasheet(
        cls,
        displacement: Displacement,
        rated_speed: RatedSpeed,
        volumetric_efficiency: VolumetricEfficiency,
        rated_pressure: RatedPressure,
        max_torque: MaxTorque,
        inertia: Inertia,
        volume: Volume,
        bulk_modulus: BulkModulus,
        relief: ReliefValve,
        speed_gain: SpeedGain,
        viscous: ViscousFriction = 0.0,
        return_pressure: ReturnPressure = 0.0,
        free_air: FreeAir = 5e-3,
        accumulator: Accumulator = NONE,
        poppet: Poppet = INSTANT,
    ) -> "PumpSupply":
        """The supply whose pump delivers eta D w_n at its rated speed w_n, p_n above the return pressure.

        The rest leaks, L = (1 - eta) D w_n/p_n. The motor is asked for the speed by which its load slows it
        down, too: w_ref = w_n + (D p_n + B w_n)/K.

        Raises:
            ParameterError: a rated value is not above 0, the efficiency is above 1, or the motor's largest
                torque does not hold the rated point.
        """
        for name, value in (("rated_speed", rated_speed), ("rated_pressure", rated_pressure)):
            if not value > 0.0:
                raise ParameterError(name, value, "must be above 0")
        if not 0.0 < volumetric_efficiency <= 1.0:
            raise ParameterError("volumetric_efficiency", volumetric_efficiency, "must be in (0, 1]")
        torque = displacement * rated_pressure + viscous * rated_speed
        if not torque <= max_torque:
            allowed = f"must be at least {torque:.4g} [N m], as the rated speed and pressure need"
            raise ParameterError("max_torque", max_torque, allowed)
        return cls(
            displacement=displacement,
            demanded_speed=rated_speed + torque / speed_gain,
            speed_gain=speed_gain,
            max_torque=max_torque,
            inertia=inertia,
            viscous=viscous,
            leakage=(1.0 - volumetric_efficiency) * displacement * rated_speed / rated_pressure,
            return_pressure=return_pressure,
            volume=volume,
            bulk_modulus=bulk_modulus,
            free_air=free_air,
            relief=relief,
            accumulator=accumulator,
            poppet=poppet,
        )

    def check(self) -> None:
        precharge = getattr(self.accumulator, "precharge", 0.0)
        if self.demanded_speed == 0.0 and precharge > 0.0:
            return  # the accumulator is alone
        idle = self.idle_pressure()
        if not min(self.relief.cracking_pressure, idle) > self.return_pressure:
            allowed = (
                f"must be above return_pressure, {self.return_pressure:g} [Pa]: "
                "raise relief.cracking_pressure, demanded_speed or max_torque"
            )
            raise ParameterError("pressure", min(self.relief.cracking_pressure, idle), allowed)
        if not precharge < idle:
            allowed = f"must be below {idle:.4g} [Pa], the pressure with the valve shut"
            raise ParameterError("accumulator.precharge", precharge, allowed)

    def caution(self) -> str:
        idle, cracking = self.idle_pressure(), self.relief.cracking_pressure
        if not idle - cracking > MOST_OVERRIDE * (cracking - self.return_pressure):
            return ""
        return (
            f"the pressure rises to {quantity(idle, 'Pa')} with the valve shut, far beyond the "
            f"{quantity(cracking, 'Pa')} of relief.cracking_pressure: the relief valve (relief.gradient) "
            "passes too little for the pump"
        )

    def init(self) -> PumpSupplyState:
        pressure = self.idle_pressure()
        delivered = self.leakage * (pressure - self.return_pressure) + self.relief.flow(pressure)
        return PumpSupplyState(
            delivered * (1.0 / self.displacement), pressure, self.poppet.steady_at(self.relief, pressure)
        )

    def idle_pressure(self) -> float:
        """The pressure at which nothing is left to draw [Pa].

        Over p, what is left is the smaller of two lines (motor below and at its largest torque) less the
        larger of two (relief valve shut and open). It falls, so its zero is the smallest of the four pairs'.
        """
        d, relief = self.displacement, self.relief.gradient
        held = relief * (self.relief.cracking_pressure - self.return_pressure)
        governed, slope = d * self.speed_gain * self.demanded_speed, self.speed_gain + self.viscous
        shut = governed / (d * d + slope * self.leakage)
        relieved = (governed + slope * held) / (d * d + slope * (self.leakage + relief))
        strained = d * self.max_torque
        shut_strained = strained / (d * d + self.viscous * self.leakage)
        relieved_strained = (strained + self.viscous * held) / (
            d * d + self.viscous * (self.leakage + relief)
        )
        rise = ops.minimum(ops.minimum(shut, relieved), ops.minimum(shut_strained, relieved_strained))
        return self.return_pressure + rise

    def deriv(self, s: PumpSupplyState, drawn: float) -> PumpSupplyState:
        rise = s.pressure - self.return_pressure
        torque = ops.clip(
            self.speed_gain * (self.demanded_speed - s.speed), -self.max_torque, self.max_torque
        )
        relieved = self.poppet.flow(s.poppet, self.relief, s.pressure)
        stored = self.displacement * s.speed - self.leakage * rise - relieved - drawn
        return PumpSupplyState(
            speed=(torque - self.displacement * rise - self.viscous * s.speed) * (1.0 / self.inertia),
            pressure=stored / self.line_compliance(s.pressure),
            poppet=self.poppet.deriv(s.poppet, self.relief, s.pressure),
        )

    def line_compliance(self, pressure: float) -> float:
        """Volume that the line takes in per pressure [m^3/Pa]."""
        absolute = ops.maximum(pressure + ATMOSPHERE, LEAST_PRESSURE)
        air = self.free_air * ATMOSPHERE / (absolute * absolute)
        return self.volume * (1.0 / self.bulk_modulus + air) + self.accumulator.compliance(pressure)

    def pressures(self, s: PumpSupplyState) -> Pressures:
        return Pressures(s.pressure, self.return_pressure)

    def simplified(self) -> IdealSupply:
        """What a design model takes it for: one pressure, whatever the flow.

        It is the relief valve's cracking pressure, or what the motor holds with the valve shut if less.
        """
        pressure = ops.minimum(self.relief.cracking_pressure, self.idle_pressure())
        return IdealSupply(pressure, self.return_pressure)
