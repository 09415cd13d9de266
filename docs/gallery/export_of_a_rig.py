# %% [markdown]
# # The export of a rig
#
# A test rig's software writes what it knows above the table, names the channels in its own words, puts the
# units in a line below and writes decimal commas. Its pressure transducers give 4 to 20 mA. None of it
# needs editing by hand. The rig here is a simulation, so that what is found can be held against what is
# true.

# %%
from pathlib import Path

import numpy as np

import hydroservo as hs

demand = {"simulation.duration": "1 s", "simulation.record_period": "1 ms", "reference.period": "0.2 s"}
truth = {
    "uncertainty.scale": 0,
    "plant.mass": "8 kg",
    "plant.bulk_modulus": "9000 bar",
    "valve.time_constant": "12 ms",
}
rig = hs.simulate(hs.load_scenario("rig/1khz-pi-square", demand | truth))

noise = np.random.default_rng(seed=0)
pressure = rig["plant.hydraulic_force"].values / 4.91e-4  # of the area; Pa
columns = [
    rig["time"].values,
    rig["controller.u"].values,
    1e3 * rig["plant.velocity"].values + noise.normal(scale=0.2, size=rig.sizes["time"]),
    12.0 + 8.0 * pressure / 50e5 + noise.normal(scale=0.005, size=rig.sizes["time"]),
]
head = """Test\tAxis, square
Rig\t3
Sample rate\t1000\tHz
Channels\t4

Zeit\tSollwert Ventil\tKolben\tDifferenzdruck
s\tV\tmm/s\tmA
"""
rows = ["\t".join(f"{x:.4f}" for x in row).replace(".", ",") for row in zip(*columns, strict=True)]
Path("rig.txt").write_text(head + "\n".join(rows) + "\n", encoding="cp1252")
print(Path("rig.txt").read_text(encoding="cp1252")[:260])

# %% [markdown]
# The scenario says which channel is which. A transducer of ±50 bar on 4 to 20 mA has a scale and an offset:
# on a piston of 4.91 cm², 8 mA are 2.455 kN.

# %%
Path("rig.toml").write_text("""
base = "rig/1khz-pi-square"
uncertainty = { scale = 0 }

[identify.columns]
time = "Zeit"
command = "Sollwert Ventil"
velocity = "Kolben"
hydraulic_force = { column = "Differenzdruck", scale = "306.875 N/mA", offset = "-3682.5 N" }
""")
ranges = {"plant.mass": "-40%..+70%", "plant.bulk_modulus": "-40%..+70%", "valve.time_constant": "5..20 ms"}
found = hs.identify("rig.toml", "rig.txt", ranges)
found

# %% [markdown]
# The true values are 8 kg, 9000 bar and 12 ms.

# %%
picture = hs.plot(found)
picture.save("export_of_a_rig.png")
picture
