"""All peers, hydroservo first."""

from benchmarks.peer import Peer
from benchmarks.peers import c, casadi, control, cuda_c, diffrax, jax, numba, ours, scipy

__all__ = ["ALL", "DEVICE_YARDSTICK", "ON_DEVICE", "YARDSTICK", "named"]

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
DEVICE_YARDSTICK = ours.Ours("hydroservo on the device", cuda=True)
ON_DEVICE: tuple[Peer, ...] = (
    DEVICE_YARDSTICK,
    ours.Ours("hydroservo strict on the device", strict=True, cuda=True),
    cuda_c.CudaC("CUDA C"),
    cuda_c.CudaC("CUDA C in single precision", single=True),
    ours.AllCores(),
)


def named(name: str) -> Peer:
    """The peer of a name."""
    return next(peer for peer in (*ALL, *ON_DEVICE) if peer.name == name)
