# %% [markdown]
# # Tune it
#
# A PI that somebody set by hand, and the one that a search of 256 candidates finds for the same demand.
# The same seed finds the same bits on any number of cores.

# %%
import hydroservo as hs

by_hand = {"controller.proportional_gain": 1.0, "controller.integral_gain": 100.0}
jumps = {"reference.period": "0.5 s", "simulation.duration": "0.75 s"}
loop = hs.load_scenario("rig/1khz-pi-square", by_hand | jumps)
ranges = {"controller.proportional_gain": (0.3, 30.0), "controller.integral_gain": (10.0, 10_000.0)}
found = hs.tune(hs.Aim([loop], metric="rms_error"), ranges, candidates=256)
found

# %%
tuned = hs.replace(loop, found.parameters)
picture = hs.plot({"by hand": hs.simulate(loop), "tuned": hs.simulate(tuned)})
picture.save("tune_it.png")
picture
