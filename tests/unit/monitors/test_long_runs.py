"""What a run says of its oscillation against the spectrum of one ten times as long."""

import numpy as np
import pytest

from hydroservo import simulate
from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.linear.onset import with_amplified_command
from hydroservo.runs.cautions import quietly
from tests.support.brink import at_the_brink


def with_gain(name: str, factor: float, times: float = 1.0) -> Loop:
    loop = at_the_brink(name)
    given = loop.simulation
    simulation = given._replace(duration=times * given.duration, record_period=given.period)
    return with_amplified_command(loop._replace(simulation=simulation), factor)


def line_of(loop: Loop) -> tuple[float, float]:
    """Amplitude [V] and frequency [Hz] of the command over the last fifth, less a parabola."""
    run = quietly(simulate)(loop, record=["controller.u"], metrics=[])
    u = run["controller.u"].values
    u = u[-len(u) // 5 :]
    x = np.linspace(-1.0, 1.0, u.size)
    rest = u - np.polynomial.Polynomial.fit(x, u, 2)(x)
    lines = np.abs(np.fft.rfft(rest * np.hanning(u.size)))
    frequency = int(lines.argmax()) / (u.size * loop.simulation.period)
    return float(np.sqrt(2.0) * rest.std()), frequency


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("axis/crane", 1.0),
        ("axis/force", 3.0),
        ("axis/position", 3.0),
        ("axis/pump-controlled", 3.0),
        ("cases/dead-band", 2.0),
        ("cases/encoder", 3.0),
        ("rig/1khz-pi-square", 3.0),
        ("rig/noisy-1khz-pi-sine", 4.0),
    ],
)
def test_an_oscillation_has_the_size_and_the_frequency_that_lasts(name: str, factor: float) -> None:
    run = quietly(simulate)(with_gain(name, factor))  # a command beyond the valve's is warned of
    amplitude, frequency = line_of(with_gain(name, factor, 10.0))
    assert float(run["oscillation_command"]) == pytest.approx(amplitude, rel=0.1)
    assert float(run["oscillation_frequency"]) == pytest.approx(frequency, rel=0.1)


def test_a_loop_whose_long_run_comes_to_rest_does_not_oscillate() -> None:
    assert line_of(with_gain("axis/pump-controlled", 1.0, 10.0))[0] < Oscillation().threshold
    assert float(quietly(simulate)(with_gain("axis/pump-controlled", 1.0))["oscillation_command"]) == 0.0
