"""Promises of hydroservo that are counted: each is a number of attempts to break it, from a seed."""
