"""When the second half of a run begins."""

HALF = 0.5 * (1.0 - 1e-12)  # of the duration: a sample that lies at half of it but for rounding counts
