"""What the laws of dry friction have in common."""

from hydroservo.core.errors import ParameterError


def check_breakaway(coulomb: float, breakaway: float) -> None:
    """Refuse a friction that holds less than it brakes.

    Args:
        coulomb: Coulomb friction F_c, in motion [N].
        breakaway: breakaway force F_s, at rest [N].

    Raises:
        ParameterError: the breakaway force is below Coulomb friction.
    """
    if not breakaway >= coulomb:
        raise ParameterError("breakaway", breakaway, f"must be at least coulomb, {coulomb:g} [N]")
