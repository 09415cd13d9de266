"""Gains designed off line, before a run: linear models, how they are sampled, and Riccati equations.

Nothing here is a block, and scipy is loaded where something is designed.
"""
