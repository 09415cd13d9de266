# %% [markdown]
# # A study and its verdict
#
# Two laws on one machine with a slow and with a quick valve. The study searches the gains of both with the
# same budget, judges what was found under conditions that no search has seen, and says who wins, who ties,
# and how sure that is. The one here is as short as can be; {doc}`the page on studies <../studies>` says
# what one may hold.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

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
candidates = 64
seeds = 2
efforts = [0.1]
"""


def main():
    """Does it; in a function, for a study works in processes, and each imports this file."""
    Path("valves.toml").write_text(ASKED, encoding="utf-8")
    return hs.study("valves.toml", "study", workers=1)


found = main() if __name__ == "__main__" else None
found

# %% [markdown]
# Each dot is a run under one of the conditions that no search has seen, with the gains of one of two
# searches. A dot far above the others is a run that gains found under so few conditions did not bear.
# `hs.plot(found)` is the map of who wins where.

# %%
if found is not None:
    runs = found.table.query("split == 'test'")
    picture, axes = plt.subplots(1, 2, figsize=(6.3, 3.0), sharey=True, layout="constrained")
    for axis, (valve, there) in zip(axes, runs.groupby("cell", observed=True), strict=True):
        for place, (law, own) in enumerate(there.groupby("law", observed=True)):
            spread = place + 0.25 * np.linspace(-1.0, 1.0, len(own))
            axis.semilogy(spread, 1e3 * own["error"], ".", label=law, alpha=0.7)
        axis.set(title=f"{valve} valve", xticks=[])
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("rms error [mm/s]")
    axes[1].legend()
    picture.savefig("laws_in_a_study.png")
