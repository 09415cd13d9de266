"""What a scenario's table ``[identify]`` says of logs of its machine, and of what is sought in them."""

from collections.abc import Collection

from hydroservo.block import leaves
from hydroservo.loop import Loop
from hydroservo.scenario.records.columns import column_source
from hydroservo.scenario.records.series import sample_period
from hydroservo.scenario.tables import Entry, Table

COLUMNS, VARY = KEYS = "columns", "vary"


def log_columns(scenario: Table) -> dict[str, Entry]:
    """The columns of signals that the table names, as ``velocity = "v_piston [mm/s]"``, and the period.

    Args:
        scenario: all its tables.

    Raises:
        ScenarioError: an unknown key, or a column that is none.
    """
    table = scenario.table("identify")
    for name in table.names():
        if name not in KEYS:
            raise table.entry(name).unknown(name, KEYS)
    columns = table.table(COLUMNS)
    found = {name: columns.entry(name) for name in columns.names()}
    for name, entry in found.items():
        try:
            (sample_period if name == "period" else column_source)(entry.value)
        except ValueError as error:
            raise entry.error(str(error)) from None
    return found


def log_ranges(scenario: Table, loop: Loop, arguments: Collection[str]) -> dict[str, Entry]:
    """The ranges of the numbers that are sought, by path, such as ``plant.mass = "-40%..+70%"``.

    Those that a base gives for a block of another type than the loop's are left out.

    Args:
        scenario: all its tables.
        loop: what they describe.
        arguments: what constructors take, by path.
    """
    entries = dict(scenario.table("identify").table(VARY).entries())
    known = {*arguments, *(path for path, _ in leaves(loop))}
    return {
        path: entry
        for path, entry in entries.items()
        if path in known or not scenario.has_type_above(entry.origin, path)
    }
