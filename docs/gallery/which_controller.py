# %% [markdown]
# # Which controller?
#
# Four laws on one machine, with one demand and one digital loop, each with gains that one and the same
# search found for it.

# %%
import pandas as pd

import hydroservo as hs

names = {"PI": "pi", "first-order ADRC": "adrc-1", "linear quadratic": "lq", "fast terminal": "fast-terminal"}
jumps = {"reference.period": "0.5 s", "simulation.duration": "0.75 s", "simulation.record_period": "1 ms"}
runs = {law: hs.simulate(hs.load_scenario(f"laws/{name}-square", jumps)) for law, name in names.items()}
hs.differences([*runs.values()])

# %% [markdown]
# Nothing is listed: they differ in their controllers alone, so that they may be compared.

# %%
metrics = ["rms_error", "overshoot", "settling_time", "control_total_variation"]
pd.DataFrame({law: hs.metrics_of(run) for law, run in runs.items()}).T[metrics]

# %%
picture = hs.plot(runs)
picture.save("which_controller.png")
picture
