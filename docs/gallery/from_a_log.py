# %% [markdown]
# # From a log to the machine
#
# A bench recorded its command, and with noise the velocity and the hydraulic force. Its piston with all that
# it carries is heavier and its valve slower than anyone said. The bench here is a simulation too, so that the
# estimates can be compared with the truth.

# %%
import numpy as np

import hydroservo as hs

demand = {"simulation.duration": "0.5 s", "simulation.record_period": "1 ms", "reference.period": "0.2 s"}
truth = {"plant.mass": 8.0, "valve.time_constant": 0.012}
bench = hs.simulate(hs.load_scenario("rig/1khz-pi-square", demand | truth))

noise = np.random.default_rng(seed=0)
log = {
    "time": bench["time"].values,
    "command": bench["controller.u"].values,
    "velocity": bench["plant.velocity"].values + noise.normal(scale=2e-4, size=bench.sizes["time"]),
    "hydraulic_force": bench["plant.hydraulic_force"].values
    + noise.normal(scale=5.0, size=bench.sizes["time"]),
}

# %%
ranges = {"plant.mass": "-40%..+70%", "plant.bulk_modulus": "-40%..+70%", "valve.time_constant": "5..20 ms"}
found = hs.identify("rig/1khz-pi-square", log, ranges)
found

# %% [markdown]
# `print(found.toml())` is a scenario with these numbers and, from the intervals, the uncertainty that is
# left.

# %%
picture = hs.plot(found)
picture.save("from_a_log.png")
picture
