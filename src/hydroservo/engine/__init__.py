"""Compiles and runs systems of blocks; knows no physics."""
