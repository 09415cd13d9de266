"""Arrays of numbers."""

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
