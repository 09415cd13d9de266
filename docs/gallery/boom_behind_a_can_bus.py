# %% [markdown]
# # A boom behind a CAN bus
#
# A controller logged the boom of a small excavator every 20 ms: the clock, the joystick's command in percent
# and the boom's angle in degrees. The bus and the pilot stage delay the command, nobody knows the weight on
# the bucket, and of the valve there is a datasheet. The machine here is a simulation, so that what is found
# can be held against what is true.

# %%
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

import hydroservo as hs
from hydroservo.core.time_series import TimeSeries

Path("boom.toml").write_text("""
controls = { type = "Command" }
controller = { type = "OpenLoop" }
reference = { type = "Step", initial = "0 V", final = "0 V", time = "0 s" }
supply = { type = "IdealSupply", supply_pressure = "180 bar" }
load = { type = "Constant", amplitude = "3 kN" }
simulation = { duration = "12 s", period = "20 ms", substeps = "auto", tolerance = 1e-4 }

[plant]
type = "Cylinder.from_diameters"
bore = "63 mm"
rod = "36 mm"
stroke = "500 mm"
start_position = "200 mm"
mechanism = { type = "Mass", mass = "300 kg" }
oil = { type = "ConstantOil", effective_bulk_modulus = "8000 bar" }
friction = { type = "Viscous", coefficient = "6000 N s/m" }

[valve]
type = "FirstOrderValve"
time_constant = "100 ms"
gain = "0.1 mm/V"
max_opening = "1 mm"
orifice = { type = "FourEdges.rated", rated_flow = "30 L/min", rated_drop = "10 bar", rated_opening = "1 mm" }

[identify.columns]
command = { column = "Joystick", scale = "0.1 V/%" }
position = { column = "Boom", scale = "7.5 mm/deg" }

[identify.vary]
load.amplitude = "0..12 kN"
valve.time_constant = "10..300 ms"
valve.orifice.rated_flow = "10..60 L/min"
""")

# %% [markdown]
# The controller's log, with the true numbers: 5 kN, 60 ms and 24 L/min, 280 ms late. The angle is
# resolved to a hundredth of a degree.

# %%
truth = {
    "load.amplitude": "5 kN",
    "valve.time_constant": "60 ms",
    "valve.orifice.rated_flow": "24 L/min",
}
moves = np.random.default_rng(seed=3).choice([-0.4, -0.2, 0.15, 0.3, 0.5], size=20)
joystick = np.repeat(np.concatenate([[0.0], 100.0 * moves]), 30)  # %, each for 0.6 s
time = 0.02 * np.arange(joystick.size)
late = np.interp(time - 0.28, time, 0.1 * joystick)  # V
demand = hs.references.Recorded(TimeSeries.from_samples(time, late))
boom = hs.load_scenario("boom.toml", truth | {"simulation.duration": time[-1]})
run = hs.simulate(hs.replace(boom, {"reference": demand}))

noise = np.random.default_rng(seed=4).normal(scale=0.01, size=joystick.size)
angle = np.round(run["plant.position"].values / 7.5e-3 + noise, 2)
start = datetime(2026, 5, 4, 8, 30)
rows = [
    f"{start + timedelta(milliseconds=20 * k):%d.%m.%Y %H:%M:%S.%f};{joystick[k]:.0f};{angle[k]:.2f}"
    for k in range(len(angle))
]
Path("boom.csv").write_text("Time;Joystick [%];Boom [deg]\n" + "\n".join(rows) + "\n")
print(Path("boom.csv").read_text()[:160])

# %% [markdown]
# The scenario says what the columns are: `0.1 V/%` is the amplifier, 7.5 mm of cylinder a degree of the
# boom. `hydroservo log boom.csv --scenario boom.toml` shows how the log is understood. What is sought, and
# within which limits, stands in the scenario too, so nothing else is needed.

# %%
found = hs.identify("boom.toml", "boom.csv", {})
found

# %% [markdown]
# The weight pushes one way, so that the two speeds tell it; the delay is found with the rest.

# %%
picture = hs.plot(found)
picture.save("boom_behind_a_can_bus.png")
picture
