"""A pump on a servo motor, with relief valve, line and accumulator."""

from typing import Annotated, NamedTuple

from hydroservo import ops
from hydroservo.block import Accumulator, Field
from hydroservo.signals import Pressures
from hydroservo.sources import CHOSEN, TSMC_EHA_2021
from hydroservo.supplies.accumulator import ATMOSPHERE, NoAccumulator
from hydroservo.supplies.ideal import IdealSupply
from hydroservo.supplies.relief import ReliefValve

__all__ = ["PumpSupply", "PumpSupplyState"]

LEAST_PRESSURE = 1.0  # [Pa] absolute, at which the air is thought to grow no more


class PumpSupplyState(NamedTuple):
    """The shaft's speed and the line's pressure."""

    speed: Annotated[float, Field("rad/s", "speed of the shaft")]
    pressure: Annotated[float, Field("Pa", "pressure in the supply line")]


class PumpSupply(NamedTuple):
    """A fixed-displacement pump turned by a speed-controlled motor, feeding a line with a relief valve.

    With the shaft's speed w, the line's pressure p, its absolute value p_abs = p + 1 bar, the return pressure
    p_r, the pump's displacement D and the flow Q drawn by the servo valve::

        J dw/dt = T - D (p - p_r) - B w      T = K (w_ref - w) within +-T_max
        C dp/dt = D w - L (p - p_r) - Q_relief(p) - Q
        C       = V (1/beta_e + a 1 bar/p_abs^2) + C_accumulator(p)

    The free air a is what keeps p above -1 bar however much is drawn: the line then fills with it. The
    motor has no integral action, so the load D (p - p_r) costs it the speed D (p - p_r)/(K + B). All starts
    steady with the valve shut, at the pressure where the relief valve takes what the pump delivers.

    Source: Merritt, Hydraulic Control Systems, 1967 (pumps, continuity of a compressed volume).
    Fails where the flow pulsates with the pump's pistons, where the line is long enough for waves, and where
    the pump cannot suck: its losses are proportional to pressure and speed here.
    """

    displacement: Annotated[float, Field("m^3/rad", "displacement of the pump", CHOSEN, above=0)] = 3.2e-7
    demanded_speed: Annotated[float, Field("rad/s", "demanded speed", CHOSEN, at_least=0)] = 157.0
    speed_gain: Annotated[float, Field("N m s/rad", "gain of the speed control", CHOSEN, above=0)] = 1.0
    max_torque: Annotated[float, Field("N m", "largest torque of the motor", CHOSEN, above=0)] = 5.0
    inertia: Annotated[float, Field("kg m^2", "inertia of motor and pump", CHOSEN, above=0)] = 2e-3
    viscous: Annotated[float, Field("N m s/rad", "viscous friction of both", CHOSEN, at_least=0)] = 1e-3
    leakage: Annotated[float, Field("m^3/(s Pa)", "leakage of the pump", CHOSEN, at_least=0)] = 7e-13
    return_pressure: Annotated[float, Field("Pa", "return pressure p_r", TSMC_EHA_2021, at_least=0)] = 2e5
    volume: Annotated[float, Field("m^3", "oil between pump and valve", CHOSEN, above=0)] = 2e-4
    bulk_modulus: Annotated[float, Field("Pa", "bulk modulus of oil and line", TSMC_EHA_2021, above=0)] = 7e8
    free_air: Annotated[
        float, Field("", "free air at 1 bar absolute, as a share of the volume", CHOSEN, above=0, below=1)
    ] = 5e-3
    relief: ReliefValve = ReliefValve()
    accumulator: Accumulator = NoAccumulator()

    def init(self) -> PumpSupplyState:
        pressure = self.idle_pressure()
        delivered = self.leakage * (pressure - self.return_pressure) + self.relief.flow(pressure)
        return PumpSupplyState(delivered * (1.0 / self.displacement), pressure)

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
        stored = self.displacement * s.speed - self.leakage * rise - self.relief.flow(s.pressure) - drawn
        return PumpSupplyState(
            speed=(torque - self.displacement * rise - self.viscous * s.speed) * (1.0 / self.inertia),
            pressure=stored / self.line_compliance(s.pressure),
        )

    def line_compliance(self, pressure: float) -> float:
        """Volume that the line takes in per pressure [m^3/Pa]."""
        absolute = ops.maximum(pressure + ATMOSPHERE, LEAST_PRESSURE)
        air = self.free_air * ATMOSPHERE / (absolute * absolute)
        return self.volume * (1.0 / self.bulk_modulus + air) + self.accumulator.compliance(pressure)

    def pressures(self, s: PumpSupplyState) -> Pressures:
        return Pressures(s.pressure, self.return_pressure)

    def simplified(self) -> IdealSupply:
        """What a design model takes it for: the cracking pressure of its relief valve, whatever the flow."""
        return IdealSupply(self.relief.cracking_pressure, self.return_pressure)
