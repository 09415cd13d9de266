"""Where numbers come from, named once."""

CHOSEN = "chosen here"
DATASHEET = "datasheet"
