"""The machine: plants, valves, drives, supplies, oils, loads, sensors, their integrators and theory."""
