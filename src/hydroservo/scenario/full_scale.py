"""What the converter's 10 V stand for, from a scenario's ``[command]``."""

from hydroservo.command_scale import FULL, VOLTS, CommandScale
from hydroservo.scenario.quantities import si_value
from hydroservo.scenario.tables import Table

FULL_SCALE = "full_scale"
ALLOWED = f'must be what {FULL} V of command stand for: a current such as "40 mA", "100 %" or "{FULL} V"'


def full_scale_in(table: Table) -> CommandScale:
    """What a table ``[command]`` says with ``full_scale = "40 mA"``; volts without one.

    Raises:
        ScenarioError: in one line, the file, the key, the value and what is allowed.
    """
    for name in table.names():
        if name != FULL_SCALE:
            raise table.entry(name).unknown(name, [FULL_SCALE])
    if not table.has(FULL_SCALE):
        return VOLTS
    entry = table.entry(FULL_SCALE)
    unit = unit_of(entry.value)
    if unit is None:
        raise entry.error(ALLOWED)
    size = si_value(entry.value, unit)
    if size <= 0.0:
        raise entry.error("must be above 0")
    if unit == "V" and size != FULL:
        raise entry.error(ALLOWED)
    return {"A": CommandScale(current=size), "": CommandScale(share=size), "V": VOLTS}[unit]


def unit_of(value: object) -> str | None:
    """The SI unit of a full scale, "" for one in %; None where it is none."""
    for unit in ("A", "V", ""):
        if isinstance(value, str) and (unit or value.rstrip().endswith("%")):
            try:
                si_value(value, unit)
            except ValueError:
                continue
            return unit
    return None
