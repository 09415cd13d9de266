"""Logs of a bent valve in closed form, by numpy alone: what maps of characteristics are judged by."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]
Signals = dict[str, Samples]

# A valve with overlap, a kink on either side, and other flows each way: command [V] and speed [m/s].
POINTS = np.array([(-10, -0.5), (-6, -0.2), (-3, -0.08), (-0.5, 0), (0.3, 0), (4, 0.13), (10, 0.65)])
HYSTERESIS = 0.2  # full width [V]
NOISE = 0.01  # of the largest speed


def kinked(command: Samples) -> Samples:
    """The speed at each command [m/s]."""
    return np.interp(command, *POINTS.T)


class Valve(NamedTuple):
    """A valve that is drawn at random."""

    curve: Callable[[Samples], Samples]
    low: float  # end of the dead band [V]
    high: float  # the other one [V]
    width: float  # of the hysteresis [V]
    lag: float  # [s]


def drawn_valve(seed: int) -> Valve:
    """A valve with its own dead band, kink and slopes on either side, hysteresis and lag."""
    rng = np.random.default_rng([7, seed])
    low, high = -rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0)
    kinks, slopes, steeper = rng.uniform(2.5, 5.0, 2), rng.uniform(0.01, 0.04, 2), rng.uniform(1.5, 4.0, 2)
    at_kinks = slopes * (kinks - [-low, high])
    minus, plus = at_kinks + slopes * steeper * (10.0 - kinks)
    commands = [-10.0, -kinks[0], low, high, kinks[1], 10.0]
    speeds = [-minus, -at_kinks[0], 0.0, 0.0, at_kinks[1], plus]
    width, lag = rng.uniform(0.05, 0.4), rng.uniform(0.01, 0.04)
    return Valve(lambda u: np.interp(u, commands, speeds), low, high, width, lag)


def behind_play(command: Samples, width: float = HYSTERESIS) -> Samples:
    """The command behind a play."""
    spool, now = np.empty(command.size), float(command[0])
    for i, u in enumerate(command.tolist()):
        now = min(max(now, u - 0.5 * width), u + 0.5 * width)
        spool[i] = now
    return spool


def noisy(time: Samples, command: Samples, speed: Samples, seed: int) -> Signals:
    """The log of a speed with the noise of its sensor."""
    noise = np.random.default_rng(seed).normal(scale=NOISE * np.abs(POINTS[:, 1]).max(), size=time.size)
    return {"time": time, "command": command, "velocity": speed + noise}


def sweep(
    seed: int,
    curve: Callable[[Samples], Samples] = kinked,
    *,
    period: float = 40.0,
    cycles: float = 3.0,
    lag: float = 0.0,
    width: float = HYSTERESIS,
) -> Signals:
    """Sines of the command, whose rates tell a lag from a hysteresis."""
    time = np.arange(0.0, cycles * period, 1e-2)
    command = 10.0 * np.sin(2.0 * np.pi / period * time)
    late = np.interp(time - lag, time, command)
    return noisy(time, command, curve(behind_play(late, width)), seed)


def stairs(
    seed: int,
    curve: Callable[[Samples], Samples] = kinked,
    *,
    rest: float = 1.0,
    time_constant: float = 0.03,
    cycles: int = 2,
    width: float = HYSTERESIS,
) -> Signals:
    """Levels of the command, up and down on both sides, behind a lag of first order."""
    one = 10.0 * np.linspace(0.0, 1.0, 21) ** 1.5
    levels = np.tile(np.concatenate([one, one[-2::-1], -one[1:], -one[-2::-1]]), cycles)
    period = 5e-3
    command = np.repeat(levels, round(rest / period))
    behind, opening, share = behind_play(command, width), 0.0, -np.expm1(-period / time_constant)
    spool = np.empty(command.size)
    for i, u in enumerate(behind.tolist()):
        opening += share * (u - opening)
        spool[i] = opening
    return noisy(period * np.arange(command.size), command, curve(spool), seed)
