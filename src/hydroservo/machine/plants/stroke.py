"""What a stroke and what is given along it have to do with each other."""

from hydroservo.core.errors import ParameterError


def check_start(start_position: float, stroke: float) -> None:
    """Refuse a start beyond the end of the stroke.

    Args:
        start_position: of the piston, from the lower end of the stroke [m].
        stroke: its length [m].

    Raises:
        ParameterError: the piston starts beyond the stroke's upper end.
    """
    if not start_position <= stroke:
        raise ParameterError("start_position", start_position, f"must be at most the stroke, {stroke:g} [m]")
