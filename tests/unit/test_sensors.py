"""What ideal sensors pass on."""

from hydroservo.plants import LoadPressureState
from hydroservo.sensors import IdealSensors


def test_the_state_and_the_command_are_seen_as_they_are() -> None:
    assert IdealSensors().measure(LoadPressureState(0.1, 20.0, 0.03), 4.0) == (0.1, 20.0, 0.03, 4.0)
