"""Commands called in this process, and what most tests of them share."""

from typer.testing import CliRunner

from hydroservo.cli.commands import app

SHORT = ("--set", "simulation.duration=0.02")  # s; 2000 samples
QUICK = (*SHORT, "--interpreted")
UNSTABLE = ("--set", "simulation.period=1 ms", "--set", "plant.mass=10 g")  # with one step a period

PLUGIN = '''
from typing import Annotated, NamedTuple

from hydroservo import Field
from hydroservo.core.roles import Controller, role


class FixedState(NamedTuple):
    u: Annotated[float, Field("V", "command")]


@role(Controller)
class Fixed(NamedTuple):
    """A command that never changes."""

    command: Annotated[float, Field("V", "command")] = 0.01

    def init(self):
        return FixedState(0.0)

    def step(self, s, y, r, dt):
        return FixedState(self.command)
'''
SMALL = [  # of a study
    f"--set={path}={value}"
    for path, value in {
        "search.candidates": 256,
        "search.seeds": 1,
        "search.widen": 0,
        "conditions.train": 2,
        "conditions.test": 2,
        "conditions.stressed": 2,
        "set.simulation.duration": "'0.1 s'",
    }.items()
]


def hydroservo_(*args):
    """Run the command line in this process."""
    return CliRunner().invoke(app, [str(arg) for arg in args])


def succeeded(*args):
    result = hydroservo_(*args)
    assert result.exit_code == 0, result.output
    return result.stdout


def failed(*args):
    """The one line that a command says on failing."""
    result = hydroservo_(*args)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    return result.stderr
