"""Plots of any run, comparison or batch."""
