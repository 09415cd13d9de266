"""What the constants of ops are in single precision, where they depend on the format of numbers."""

OPS = "hydroservo.ops"

SINGLE = {
    (f"{OPS}.basic", "ROUNDER"): 12582912.0,  # 1.5 * 2^23
    (f"{OPS}.power", "LEAST_NORMAL"): 2.0**-126,
    (f"{OPS}.power", "SPLITTER"): 4097.0,  # 2^12 + 1
    (f"{OPS}.power", "BEYOND"): 200.0,
    (f"{OPS}.power", "STEEPEST"): 1e20,
    # pi/2 in three parts; the first two have 11 bits and less
    (f"{OPS}.circular", "HALF_PI_HIGH"): 1.5703125,
    (f"{OPS}.circular", "HALF_PI_MIDDLE"): 0.0004837512969970703,
    (f"{OPS}.circular", "HALF_PI_LOW"): 7.54978994586e-08,
    (f"{OPS}.circular", "LARGEST"): 8192.0,
    ("hydroservo.controllers.adaptive_robust", "LEAST"): 1e-37,
    ("hydroservo.pulls.implicit_reaching", "LEAST"): 1e-37,
}
