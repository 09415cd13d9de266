"""Units of work that are done once: addressed by what they are, and kept when they are done."""
