"""What the piston moves and what resists it: mechanisms, frictions and end stops, one a file."""

__all__: list[str] = []
