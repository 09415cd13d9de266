"""The machine: plants, valves, drives, loads, sensors, and what integrates them."""
