"""Which instructions compiled code may use: all that the processor has, or no more than AVX2."""

import os
from pathlib import Path

__all__ = ["ISAS", "chosen", "environment", "gcc_flags", "lanes", "used", "widest"]

ISAS = ("native", "avx2")
VARIABLE = "HYDROSERVO_BENCHMARK_ISA"


def chosen() -> str:
    """What this process was told to use."""
    return os.environ.get(VARIABLE, "native")


def environment(isa: str) -> dict[str, str]:
    """The variables of a process in which all that compiles uses this instruction set."""
    if isa == "native":
        return {VARIABLE: isa}
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    kept = {
        name: has and not name.startswith(("avx512", "avx10", "evex512")) for name, has in features.items()
    }
    allowed = ",".join(f"{'+' if has else '-'}{name}" for name, has in kept.items())
    return {
        VARIABLE: isa,
        "XLA_FLAGS": "--xla_cpu_max_isa=AVX2",
        "HYDROSERVO_CPU_FEATURES": allowed,
        "NUMBA_CPU_NAME": binding.get_host_cpu_name(),
        "NUMBA_CPU_FEATURES": allowed,
    }


def widest() -> str:
    """The widest vectors that the processor has, as far as Linux tells."""
    info = Path("/proc/cpuinfo")
    flags = set(info.read_text(encoding="utf-8").split()) if info.exists() else set()
    if {"avx512f", "avx512dq"} <= flags:
        return "AVX-512"
    return "AVX2" if {"avx2", "fma"} <= flags else "no AVX2"


def used(isa: str) -> str:
    """The widest vectors that compiled code may use."""
    return "AVX2" if isa == "avx2" else widest()


def lanes() -> int:
    """Doubles in a vector."""
    return 8 if used(chosen()) == "AVX-512" else 4


def gcc_flags() -> list[str]:
    """What gcc is told of the processor."""
    without = [] if chosen() == "native" else ["-mno-avx512f", "-mavx2", "-mfma"]
    return ["-march=native", *without, f"-mprefer-vector-width={64 * lanes()}"]
