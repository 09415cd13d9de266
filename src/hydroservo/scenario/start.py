"""Where a run starts, from a scenario's ``start``."""

from hydroservo.block import Block, leaves, state_field_at
from hydroservo.group import nested
from hydroservo.loop import Loop
from hydroservo.roles import Start
from hydroservo.scenario.build import draft, number_from
from hydroservo.scenario.tables import Entry, Layer, Table
from hydroservo.starts import AsBuilt

GIVEN = "given"
STEADY = "steady"


def start_written_out(scenario: Table) -> Table:
    """A scenario with ``start = "steady"`` as the table that it stands for.

    Raises:
        ScenarioError: the start is another word.
    """
    return scenario._replace(layers=tuple(map(written_out, scenario.layers)))


def written_out(layer: Layer) -> Layer:
    start = layer.given.get("start")
    if not isinstance(start, str):
        return layer
    if start != STEADY:
        raise Entry(layer.origin, "start", start).error(f'must be "{STEADY}", or a table')
    return layer._replace(given={**layer.given, "start": {"type": "Steady"}})


def start_in(table: Table, loop: Loop) -> Block:
    """The start that a table asks for.

    Args:
        table: ``type``, what that takes, and in ``given`` numbers of the state by their paths.
        loop: the loop, wired.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
    """
    layers = (Layer(one.origin, {k: v for k, v in one.given.items() if k != GIVEN}) for one in table.layers)
    start = draft(Start, AsBuilt(), table._replace(layers=tuple(layers))).made()
    entries = dict(table.table(GIVEN).entries())
    if not entries:
        return start
    state = loop.blocks_begin()
    known = [path for path, value in leaves(state) if isinstance(value, float)]
    numbers = {}
    for path, entry in entries.items():
        if path not in known:
            raise entry.unknown(path, known)
        numbers[path] = number_from(entry, state_field_at(loop, state, path), float)
    return start._replace(given=nested(numbers))
