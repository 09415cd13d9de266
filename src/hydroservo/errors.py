"""What goes wrong in ways a user can mend; each message is one line."""

__all__ = ["HydroservoError", "LoopError", "ParameterError", "ScenarioError"]


class HydroservoError(Exception):
    """The base of all errors that hydroservo raises for its user to mend."""


class ParameterError(HydroservoError):
    """A parameter of a block is not what it must be."""

    def __init__(self, path: str, value: object, allowed: str) -> None:
        self.path, self.value, self.allowed = path, value, allowed
        super().__init__(f"{path} = {short(value)}: {allowed}")


class ScenarioError(HydroservoError):
    """A scenario, or a file it names, does not say what it must."""

    def __init__(self, file: str, key: str, problem: str) -> None:
        self.file, self.key, self.problem = file, key, problem
        super().__init__(": ".join(part for part in (file, key, problem) if part))


class LoopError(HydroservoError):
    """Blocks that do not fit together, or a block that does not behave as one."""


def short(value: object) -> str:
    """A value as it may stand in a one-line message."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
