# %% [markdown]
# # Bode plot and margins
#
# Lines are the exact linear model of machine, sensors, law and hold as they are sampled; dots were measured
# on the simulation with many tones at once, as one would on a rig.

# %%
import hydroservo as hs

loop = hs.load_scenario("rig/1khz-pi-sine")
found = hs.bode(loop, realisations=2)
found

# %%
hs.linearize(loop, command=0.1)

# %%
picture = hs.plot(found)
picture.save("in_frequency.png")
picture
