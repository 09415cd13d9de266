"""Numbers in single precision: the constants of ``ops`` that differ there, and literals."""

import numpy as np

from hydroservo.core.errors import LoopError

OPS = "hydroservo.core.ops"
SINGLE = {
    (f"{OPS}.basic", "ROUNDER"): 12582912.0,  # 1.5 * 2^23
    (f"{OPS}.binary", "ROOT_HALF"): 0.70710677,
    (f"{OPS}.portable", "WHOLE"): 8388608.0,  # 2^23
    (f"{OPS}.power", "LEAST_NORMAL"): 2.0**-126,
    (f"{OPS}.power", "SPLITTER"): 4097.0,  # 2^12 + 1
    (f"{OPS}.power", "BEYOND"): 200.0,
    (f"{OPS}.power", "STEEPEST"): 1e20,
    # pi/2 in three parts; the first two have 11 bits and less
    (f"{OPS}.circular", "HALF_PI_HIGH"): 1.5703125,
    (f"{OPS}.circular", "HALF_PI_MIDDLE"): 0.0004837512969970703,
    (f"{OPS}.circular", "HALF_PI_LOW"): 7.54978994586e-08,
    (f"{OPS}.circular", "LARGEST"): 8192.0,
    ("hydroservo.control.controllers.adaptive_robust", "LEAST"): 1e-37,
    ("hydroservo.control.error_dynamics.implicit_reaching", "LEAST"): 1e-37,
}


def single_literal(value: float) -> str:
    """The literal of the nearest number in single precision."""
    with np.errstate(all="ignore"):
        near = np.float32(value)
    if not np.isfinite(near) or (near == 0.0 and value != 0.0):
        raise LoopError(f"the number {value!r} is out of the range of single precision; export in double")
    return repr(float(str(near)))
