"""All peers, hydroservo first."""

from benchmarks.peer import Peer
from benchmarks.peers import c, casadi, control, diffrax, jax, numba, ours, scipy

__all__ = ["ALL", "YARDSTICK", "named"]

YARDSTICK = ours.Ours()
ALL: tuple[Peer, ...] = (
    YARDSTICK,
    ours.Strict(),
    c.Scalar(),
    c.Vector(),
    numba.ByHand(),
    jax.Jax(),
    diffrax.Diffrax(),
    casadi.CasADi(),
    scipy.SciPy(),
    control.PythonControl(),
)


def named(name: str) -> Peer:
    """The peer of a name."""
    return next(peer for peer in ALL if peer.name == name)
