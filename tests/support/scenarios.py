"""The built-in scenarios that a test goes through where each of them costs seconds."""

from hydroservo.scenario import scenarios

LOOPS = [  # of laws/... the square loop is that of the sine under another demand, and all share one machine
    name for name in scenarios() if not (name.startswith("laws/") and name.endswith("-square"))
]
KNOWN = (
    "cases/dead-band",
    "cases/encoder",
    "cases/limits",
    "cases/load-step",
)  # machines of others with other numbers
MACHINES = [
    name for name in LOOPS if name not in KNOWN and (not name.startswith("laws/") or name == "laws/pi-sine")
]
