"""What the supply leaves for the valve."""

from hydroservo.machine.supplies import IdealSupply
from hydroservo.testing.examples import example


def test_the_drop_is_supply_less_return() -> None:
    assert IdealSupply(40e5, 2e5).drop() == 38e5


def test_the_print_has_no_return_pressure() -> None:
    assert example(IdealSupply).drop() == 40e5
