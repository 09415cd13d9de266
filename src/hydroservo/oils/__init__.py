"""How compressible the oil is."""

__all__: list[str] = []
