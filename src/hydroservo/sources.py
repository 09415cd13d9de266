"""Where numbers come from, named once."""

__all__ = ["CHOSEN", "DATASHEET"]

CHOSEN = "chosen here"
DATASHEET = "datasheet"
