"""What a loop answers to slow and fast motions, open and closed, from its linear model."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.controlled import Velocity
from hydroservo.control.loop import Loop
from hydroservo.core.block import values
from hydroservo.core.signals import MachineOutputs
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.linear.parts import Parts
from hydroservo.linear.system import (
    ASKED,
    COMMAND,
    DEMAND,
    FORCE,
    System,
    closed,
    opened_system,
    pushed,
    response,
)

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]


class Responses(NamedTuple):
    """Frequency responses of a loop, each of shape (frequencies,).

    Attributes:
        curves: by name; ``machine``, what is controlled by the command; ``open``, L of the loop opened at its
            command; ``closed``, what is controlled by the demand; ``sensitivity``, 1/(1 + L); ``compliance``
            and ``open_compliance``, how the rod gives way to the load, with the loop closed and with the
            command held.
        commanded: what the law asks for by what a loop is excited with: "command", "reference", "load".
    """

    curves: Mapping[str, Response]
    commanded: Mapping[str, Response]


@np.errstate(all="ignore")  # what is lost is not finite, and not drawn
def responses(point: OperatingPoint, parts: Parts, frequencies: Vector) -> Responses:
    """The responses of a loop about a point at some frequencies [rad/s].

    The demand acts by its value and both derivatives, as a law is told of them. The force acts between
    samples too, where what is sampled holds still.
    """
    w = np.asarray(frequencies, dtype=np.float64)
    whole = opened_system(point, parts)
    shut, moved = closed(whole), 1 + MachineOutputs._fields.index(giving_way(point.loop))
    signal = len(whole.c) - 1
    driven, ruled = response(whole, w), response(shut, w)
    told = np.column_stack([np.ones(len(w)), 1j * w, -(w**2)])
    push = force_columns(whole, point, parts, w)
    held = forced(whole, w, push)
    free = forced(shut, w, push + (shut.b - whole.b)[:, FORCE])
    loop = -driven[:, ASKED, COMMAND]
    sensitivity = 1.0 / (1.0 + loop)
    curves = {
        "machine": driven[:, signal, COMMAND],
        "open": loop,
        "closed": (ruled[:, signal, DEMAND] * told).sum(axis=1),
        "sensitivity": sensitivity,
        "compliance": -free[:, moved],
        "open_compliance": -held[:, moved],
    }
    commanded = {
        "command": sensitivity,
        "reference": (ruled[:, ASKED, DEMAND] * told).sum(axis=1),
        "load": free[:, ASKED],
    }
    return Responses(curves, commanded)


def giving_way(loop: Loop) -> str:
    """What of the machine is compared with the load: the velocity if controlled, else the position."""
    return "velocity" if isinstance(loop.controls, Velocity) else "position"


def force_columns(whole: System, point: OperatingPoint, parts: Parts, w: Vector) -> Response:
    """B of the force by frequency, shape (frequencies, n)."""
    columns = np.broadcast_to(whole.b[:, FORCE].astype(complex), (len(w), len(whole.b))).copy()
    columns[:, : len(values(point.machine))] = pushed(point, parts, w)
    return columns


def forced(system: System, w: Vector, columns: Response) -> Response:
    """All outputs by the force, shape (frequencies, outputs)."""
    part = system.part([FORCE], list(range(len(system.c))))
    return response(part, w, columns[..., np.newaxis])[..., 0]
