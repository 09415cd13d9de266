"""Which column of a machine's logs holds which signal, as a scenario's ``[identify.columns]`` says."""

from hydroservo.scenario.tables import Entry, Table

__all__ = ["log_columns"]

COLUMNS = "columns"


def log_columns(scenario: Table) -> dict[str, Entry]:
    """The column of each signal that the table names, such as ``velocity = "v_piston [mm/s]"``.

    Args:
        scenario: all its tables.

    Raises:
        ScenarioError: an unknown key, or a column that is no text.
    """
    table = scenario.table("identify")
    for name in table.names():
        if name != COLUMNS:
            raise table.entry(name).unknown(name, [COLUMNS])
    columns = table.table(COLUMNS)
    found = {name: columns.entry(name) for name in columns.names()}
    for entry in found.values():
        if not isinstance(entry.value, str):
            raise entry.error('must be a string: the name of a column, such as "v_piston [mm/s]"')
    return found
