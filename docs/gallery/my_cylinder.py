# %% [markdown]
# # My cylinder in 15 lines
#
# Bore, rod and stroke from the cylinder's datasheet, frequencies and rated flow from the valve's, a demand,
# and a law. Numbers are in SI units here; {doc}`scenarios <../machine>` in TOML take those of the
# datasheet.

# %%
import hydroservo as hs

mass, oil = hs.mechanics.Mass(80.0), hs.oils.ConstantOil(1.2e9)
edges = hs.valves.FourEdges.rated(rated_flow=20.0 / 6e4, rated_drop=10e5, rated_opening=1e-3)
loop = hs.Loop(
    hs.Simulation(duration=4.0, period=1e-3, substeps=hs.AUTO),
    hs.plants.Cylinder.from_diameters(bore=0.040, rod=0.022, stroke=0.200, mechanism=mass, oil=oil),
    hs.valves.SecondOrderValve.from_response(60.0, 50.0, gain=1e-4, max_opening=1e-3, orifice=edges),
    hs.supplies.IdealSupply(100e5),
    hs.references.Sine(amplitude=0.1, frequency=0.5),
    hs.controllers.PI(proportional_gain=0.4, integral_gain=1300.0),
    load=hs.loads.Constant(500.0),
)
run = hs.simulate(loop)
run

# %%
picture = hs.plot(run)
picture.save("my_cylinder.png")
picture
