"""A spring and a damper as PythonFMU3 (https://github.com/StephenSmith25/PythonFMU3) makes an FMU of them.

``pythonfmu3 build -f spring_fmu.py --no-external-tool`` writes Spring.fmu.
"""

from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability


class Spring(Fmi3Slave):
    """F = k x + d v."""

    def __init__(self, **options):
        super().__init__(**options)
        self.time = self.position = self.velocity = 0.0
        self.stiffness, self.damping = 1.0, 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent))
        for name in ("position", "velocity"):
            self.register_variable(Float64(name, causality=Fmi3Causality.input))
        for name in ("stiffness", "damping"):
            constant = {"causality": Fmi3Causality.parameter, "variability": Fmi3Variability.fixed}
            self.register_variable(Float64(name, **constant))
        self.register_variable(Float64("force", causality=Fmi3Causality.output, getter=self.force))

    def force(self):
        return self.stiffness * self.position + self.damping * self.velocity

    def do_step(self, current_time, step_size):
        return True
