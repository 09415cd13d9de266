# %% [markdown]
# # A machine that is not quite known
#
# The law believes in one bulk modulus and one leakage; the machines that it meets have others. A thousand
# of them, side by side in the vector lanes of each core:

# %%
import hydroservo as hs

loop = hs.load_scenario("rig/1khz-pi-square", {"simulation.duration": "2 s", "uncertainty.scale": 0})
ranges = {"plant.bulk_modulus": "-30%..+30%", "plant.leakage": "-50%..+100%", "plant.mass": "-30%..+30%"}
drawn = hs.draws(loop, ranges, runs=1000)
table = hs.simulate_batch(loop, drawn.parameters)
table

# %% [markdown]
# Which number does the error come from? Lines are the median and the 5 and 95 % of runs with a like value
# of it.

# %%
picture = hs.plot(table, "rms_error")
picture.save("uncertainty.png")
picture
