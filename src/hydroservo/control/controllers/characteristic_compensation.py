"""Compensation of a valve's measured characteristic by its inverse."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controllers.saturation import Saturation
from hydroservo.core.block import Block, Field
from hydroservo.core.curve import Curve
from hydroservo.core.errors import ParameterError
from hydroservo.core.roles import Controller, role
from hydroservo.core.signals import Demand, Measurement

MOST_POINTS = 512
FULL = Field("V", "command of the law for the largest flow or speed", above=0)
THRESHOLD = Field("V", "command of the law at which the dead band is passed", at_least=0)

SATURATION = Saturation()

Points = NDArray[np.float64]


class CharacteristicCompensationState(NamedTuple):
    """What is put out, and what of it makes up for the valve's characteristic."""

    u: Annotated[float, Field("V", "command")]
    added: Annotated[float, Field("V", "command besides that of the law")]
    controller: Block


@role(Controller)
class CharacteristicCompensation(NamedTuple):
    """The command of a nested law through the inverse of a valve's characteristic: one flow per command.

    u = sat(g(u_law)),  g(u_law) = C^-1(C_max u_law/full_command)

    C is the measured flow or speed over the command, C_max the larger of its ends. g is a monotone cubic
    through the points (Curve), and passes a dead band as the law's command goes from -threshold to threshold.
    The nested law learns of the applied command without what was added.

    Make it from a table with ``from_flow`` or ``from_speed``.

    Source: the inverse of a curve that is measured as in ISO 10770-1 (flow over command without load).
    Fails as the curve changes: with the drop over the valve's edges, the oil's temperature and wear. It does
    not compensate hysteresis, and where C is flat its inverse is steep and amplifies the law's noise.
    """

    controller: Controller
    inverse: Annotated[Curve, Field("V", "command over that of the law", over="V")]
    saturation: Saturation = Saturation()

    @classmethod
    def from_flow(
        cls,
        controller: Controller,
        flow: Annotated[Curve, Field("m^3/s", "flow over the command", over="V")],
        full_command: Annotated[float, FULL],
        threshold: Annotated[float, THRESHOLD] = 0.0,
        saturation: Saturation = SATURATION,
    ) -> "CharacteristicCompensation":
        """The compensation for a measured flow, 2 to 512 points.

        They rise through 0, or from 0 where both directions are alike.

        Raises:
            ParameterError: the points fall, do not pass 0 or are too many, or a dead band has no threshold.
        """
        return cls(controller, inverse_of("flow", flow, full_command, threshold), saturation)

    @classmethod
    def from_speed(
        cls,
        controller: Controller,
        speed: Annotated[Curve, Field("m/s", "speed of the axis over the command", over="V")],
        full_command: Annotated[float, FULL],
        threshold: Annotated[float, THRESHOLD] = 0.0,
        saturation: Saturation = SATURATION,
    ) -> "CharacteristicCompensation":
        """The compensation for a measured speed; the areas of a single rod are then compensated too.

        Raises:
            ParameterError: as of :meth:`from_flow`.
        """
        return cls(controller, inverse_of("speed", speed, full_command, threshold), saturation)

    def init(self) -> CharacteristicCompensationState:
        return CharacteristicCompensationState(0.0, 0.0, self.controller.init())

    def step(
        self, s: CharacteristicCompensationState, y: Measurement, r: Demand, dt: float
    ) -> CharacteristicCompensationState:
        controller = self.controller.step(s.controller, y.with_command(y.command - s.added), r, dt)
        u = self.inverse.value(controller.u)
        return CharacteristicCompensationState(self.saturation.apply(u), u - controller.u, controller)


def inverse_of(name: str, measured: Curve, full_command: float, threshold: float) -> Curve:
    """The command over that of the law [V over V].

    Args:
        name: of the parameter, for messages.
        measured: flow or speed over the command.
        full_command: of the law, for the largest flow or speed [V].
        threshold: of the law's command, within which the inverse is straight [V].

    Raises:
        ParameterError: as of ``CharacteristicCompensation.from_flow``.
    """
    command, answer = measured.knots, measured.samples
    if command[0] == answer[0] == 0.0:
        command, answer = (np.concatenate([-one[:0:-1], one]) for one in (command, answer))
    check_points(name, command, answer)
    wish = answer * (full_command / np.abs(answer).max())
    below, above = dead_band(command, answer)
    if below < above and threshold == 0.0:
        band = f"the dead band from {below:g} to {above:g} V is a jump of the inverse without one"
        raise ParameterError("threshold", threshold, f"must be above 0 V: {band}")
    if not threshold < min(-wish[0], wish[-1]):
        raise ParameterError("threshold", threshold, f"must be below {min(-wish[0], wish[-1]):g} V")
    right = branch(wish[answer > 0.0], command[answer > 0.0], above, threshold)
    left = branch(-wish[answer < 0.0][::-1], -command[answer < 0.0][::-1], -below, threshold)
    middle = np.empty((2, 0)) if threshold > 0.0 else np.array([[0.0], [above]])
    return Curve.from_samples(*np.hstack([-left[:, ::-1], middle, right]))


def branch(wish: Points, command: Points, edge: float, threshold: float) -> Points:
    """One side of the inverse, from the threshold outwards: the law's commands, and those for the valve."""
    wish, first = np.unique(wish, return_index=True)  # where the valve saturates, the smallest command
    command = command[first]
    beyond = wish > threshold
    at_threshold = np.interp(threshold, [0.0, *wish], [edge, *command])
    start = np.array([[threshold], [at_threshold]]) if threshold > 0.0 else np.empty((2, 0))
    return np.hstack([start, [wish[beyond], command[beyond]]])


def dead_band(command: Points, answer: Points) -> tuple[float, float]:
    """The commands between which nothing flows; twice the same where the curve has no flat part at 0."""
    resting = command[answer == 0.0]
    if resting.size:
        return float(resting[0]), float(resting[-1])
    through = float(np.interp(0.0, answer, command))
    return through, through


def check_points(name: str, command: Points, answer: Points) -> None:
    """Refuse what is not the rising curve of a valve.

    Raises:
        ParameterError: it is not.
    """
    if command.size > MOST_POINTS:
        raise ParameterError(name, f"{command.size} points", f"must be at most {MOST_POINTS}")
    falls = np.flatnonzero(np.diff(answer) < 0.0)
    if falls.size:
        at = f"{command[falls[0]]:g} to {command[falls[0] + 1]:g} V"
        raise ParameterError(name, f"falls from {at}", "must rise or stay level with the command")
    if not answer[0] < 0.0 < answer[-1]:
        raise ParameterError(name, f"{answer[0]:g} to {answer[-1]:g}", "must go from below 0 to above 0")
