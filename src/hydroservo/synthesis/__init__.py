"""Computed before a run: what makes a law's numbers from a model of the machine."""
