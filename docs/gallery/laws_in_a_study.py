# %% [markdown]
# # A study and its verdict
#
# Two laws on one machine with a slow and with a quick valve. The study searches what error each can have at
# what activity of its command, judges what was found under conditions that no search has seen, and says who
# wins and who ties at equal activity. The one here is as short as can be;
# {doc}`the page on studies <../studies>` says what one may hold.

# %%
from pathlib import Path

import hydroservo as hs

ASKED = """
title = "PI and LQI, two valves"
base = "rig/1khz"
reference = "pi"
set = { uncertainty.scale = 0, simulation.duration = "0.5 s" }

laws.pi = { scenario = "laws/pi-sine", family = "PI" }
laws.lqi = { scenario = "laws/lqi-sine", family = "linear quadratic" }

[axes.valve]
label = "time constant of the valve"
levels.slow = { label = "10 ms", value = 0.010, set.valve.time_constant = "10 ms" }
levels.quick = { label = "3 ms", value = 0.003, set.valve.time_constant = "3 ms" }

[conditions]
train = 3
validation = 3
test = 8
vary = { "plant.mass" = "-30%..+60%", "plant.bulk_modulus" = "-30%..+30%", "load.amplitude" = "20..150 N" }
kinds.sine.set.reference = { type = "Sine", amplitude = "30 mm/s", frequency = "2 Hz" }

[search]
candidates = 256
"""


def main():
    """Does it; in a function, for a study works in processes, and each imports this file."""
    Path("valves.toml").write_text(ASKED, encoding="utf-8")
    return hs.study("valves.toml", "study", workers=1)


found = main() if __name__ == "__main__" else None
found

# %% [markdown]
# The fronts: what error each law leaves at what activity of its command, on conditions that no search has
# seen, over that of the PI at its own activity. Dots are the points at which the laws are compared, bands
# are intervals.

# %%
if found is not None:
    hs.plot(found).save("laws_in_a_study.png")
