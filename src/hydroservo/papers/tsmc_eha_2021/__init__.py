"""Terminal sliding mode velocity control of the electro-hydraulic actuator with lumped uncertainty.

doi:10.1007/s42401-021-00087-w, 2021: a terminal sliding mode law with a terminal sliding mode disturbance
observer against PI and backstepping, under parametric uncertainty and unknown load.
"""

TITLE = "Terminal sliding mode velocity control of the electro-hydraulic actuator with lumped uncertainty"
DOI = "10.1007/s42401-021-00087-w"
