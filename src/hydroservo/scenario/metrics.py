"""The monitors of a run from a scenario's ``[metrics]``."""

from hydroservo.block import Block
from hydroservo.group import group
from hydroservo.loop import Loop
from hydroservo.metrics import usual
from hydroservo.monitors.group import Usual, is_name
from hydroservo.roles import Monitor
from hydroservo.scenario.build import Context, draft
from hydroservo.scenario.tables import Table

USUAL = "usual"


def metrics_in(table: Table, loop: Loop) -> Block:
    """The monitors that a table asks for: the usual ones, with those in it besides or in their place.

    Args:
        table: a table for each monitor, by a name of its own, with ``type`` and its parameters; one of a
            usual monitor's name takes its type and its place. ``usual = false`` leaves the usual ones out.
        loop: the loop.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
    """
    names = [name for name in table.names() if name != USUAL]
    if not table.names():
        return Usual()
    wanted = table.entry(USUAL).value if table.has(USUAL) else True
    if not isinstance(wanted, bool):
        raise table.entry(USUAL).error("must be true or false: whether the usual metrics count too")
    every, found = usual(loop), ({USUAL: Usual()} if wanted else {})
    context = Context(controlled=loop.controls.declared())
    for name in names:
        if not is_name(name):
            raise table.entry(name).error("must stand under a name of letters, digits and underscores")
        found[name] = draft(Monitor, every.get(name), table.table(name), context).made()
    return group(found)
