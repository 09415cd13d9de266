"""The stretches of time that Figures 3 to 10 show, by demand."""

from hydroservo.figures import panels
from hydroservo.figures.panels import Window
from hydroservo.papers.tsmc_eha_2021.machine import DURATION, PERIOD

START = 0.03  # [s] how much of the start from rest is shown
JUMP = 0.5 * PERIOD  # [s] the square's first
TROUGH = 0.75 * PERIOD  # [s] the sine's first

WHOLE = panels.WHOLE._replace(stop=DURATION)
SHORT = {
    "sine": Window("start", 0.0, START, label="time [ms]", factor=1e3, dots=True),
    "square": Window(
        f"jump at {JUMP:g} s", JUMP - 0.01, JUMP + 0.06, JUMP, "time after the jump [ms]", 1e3, dots=True
    ),
}
CLOSE = {
    "sine": Window("trough, close by", TROUGH - 0.1, TROUGH + 0.1),
    "square": Window("after the jump, close by", JUMP + 0.1, JUMP + 0.5 * PERIOD - 0.1),
}
