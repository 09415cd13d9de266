"""Constants of nature and of standards, each stated once."""

ATMOSPHERE = 101325.0  # [Pa] standard atmosphere, absolute, at a gauge pressure of 0: 10th CGPM, 1954
GRAVITY = 9.80665  # [m/s^2] standard acceleration of free fall: 3rd CGPM, 1901
