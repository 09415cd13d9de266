# %% [markdown]
# # A MATLAB matrix
#
# `save('run7.mat', 'data')` leaves a matrix: one row per sample, and nothing that says what its columns are.
# In a scenario they are `data[1]`, `data[2]` and so on, as MATLAB counts them, each with its signal and its
# unit. The machine here is a simulation, so that what is found can be held against what is true.

# %%
from pathlib import Path

import numpy as np
from scipy.io import savemat

import hydroservo as hs

demand = {"simulation.duration": "2.5 s"}
truth = {"uncertainty.scale": 0, "plant.mechanism.mass": "90 kg", "valve.orifice.rated_flow": "17 L/min"}
axis = hs.simulate(hs.load_scenario("axis/position", demand | truth))

noise = np.random.default_rng(seed=0)
names = ("controller.u", "plant.position", "plant.pressure_a", "plant.pressure_b")
units = (1.0, 1e-3, 1e5, 1e5)  # V, mm and bar
scatter = (0.0, 0.005, 0.1, 0.1)
data = [axis["time"].values]
data += [
    axis[name].values / unit + noise.normal(scale=scale, size=axis.sizes["time"])
    for name, unit, scale in zip(names, units, scatter, strict=True)
]
savemat("run7.mat", {"data": np.column_stack(data)})

# %%
Path("axis.toml").write_text("""
base = "axis/position"
uncertainty = { scale = 0 }

[identify.columns]
time = "data[1] [s]"
command = "data[2] [V]"
position = "data[3] [mm]"
pressure_a = "data[4] [bar]"
pressure_b = "data[5] [bar]"
""")
ranges = {"plant.mechanism.mass": "50..150 kg", "valve.orifice.rated_flow": "10..30 L/min"}
found = hs.identify("axis.toml", "run7.mat", ranges)
found

# %% [markdown]
# The true values are 90 kg and 17 L/min. Files of version 7.3, structures (`log.time`) and the matrices of a
# Simulink model (`tout`, `yout[1]`) are read in the same way.

# %%
picture = hs.plot(found)
picture.save("a_matrix_of_matlab.png")
picture
