# %% [markdown]
# # To the Cortex-M
#
# A law as C99 without allocation, with test vectors and a program that replays them. Where this computer
# has a C compiler, the C is held against Python before it is written, bit for bit.

# %%
import matplotlib.pyplot as plt
import pandas as pd

import hydroservo as hs

names = {"PI": "pi", "first-order ADRC": "adrc-1", "linear quadratic": "lq", "fast terminal": "fast-terminal"}
loops = {law: hs.load_scenario(f"laws/{name}-square") for law, name in names.items()}
exports = {law: hs.export_c(loop, names[law]) for law, loop in loops.items()}
exports["first-order ADRC"]

# %% [markdown]
# What a step takes is counted in the terms of which the C is written, at most: of ways that part, the
# dearer one. The page {doc}`on the target <../target>` has the instructions of a Cortex-M4F and a
# Cortex-M7, counted on emulated boards.

# %%
units = {law: export.unit for law, export in exports.items()}
cost = pd.DataFrame({law: unit.operations._asdict() for law, unit in units.items()}).T
cost["bytes of state"] = [8 * len(unit.states) for unit in units.values()]
cost

# %% [markdown]
# Is the dearer law worth it? The error that each leaves, over what a sample of it takes.

# %%
picture, axis = plt.subplots(figsize=(6.3, 3.4), layout="constrained")
for law, loop in loops.items():
    error = 1e3 * float(hs.simulate(loop, record=())["rms_error"])
    axis.semilogx(units[law].operations.total, error, "o")
    axis.annotate(law, (units[law].operations.total, error), xytext=(-10, 7), textcoords="offset points")
axis.set(xlabel="operations of a sample, at most", ylabel="rms error [mm/s]")
axis.margins(0.25)
axis.grid(alpha=0.3)
picture.savefig("to_the_cortex_m.png")
