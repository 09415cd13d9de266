"""The paper's machine without uncertainty and its three laws, on which scenarios of tests build."""

from pathlib import Path

__all__ = ["on_base"]


def on_base(text: str, law: str = "pi") -> str:
    """A scenario's text, to lie over that of the machine with a law: pi, tsmc or backstepping."""
    return f"base = '{Path(__file__).with_name(law)}.toml'\n{text}"
