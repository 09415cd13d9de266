"""What was shown of an export, as a line for a terminal."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydroservo.export.c.project import Proof

__all__ = ["proof_line"]


def proof_line(proof: "Proof", prefix: str) -> str:
    """Whether the C passed its vectors here, and how much of it they reach."""
    passed = f"checked with {proof.compiler}: {proof.samples} samples bit for bit"
    said = f"not checked: {proof.unproved}" if proof.unproved else passed
    if proof.uncounted:
        return said if proof.uncounted == proof.unproved else f"{said}; {proof.uncounted}"
    if not proof.branches:
        return f"{said}; its blocks have no branches"
    reached = f"{said}; {proof.reached} of {proof.branches} branches of its blocks reached"
    if not proof.missed:
        return reached
    numbers, left = ", ".join(map(str, proof.missed)), proof.branches - proof.reached
    lines = f"line{'s' if len(proof.missed) > 1 else ''} {numbers} of {prefix}.c"
    return f"{reached}, {left} not reached, in {lines}: {', '.join(proof.methods)}"
