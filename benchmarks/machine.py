"""What the benchmark ran on."""

import os
import platform
import re
import shutil
import subprocess
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from benchmarks import isa

__all__ = ["described", "device_described"]

PACKAGES = ("hydroservo", "numba", "numpy", "scipy", "jax", "diffrax", "casadi", "control")
ON_DEVICE = ("llvmlite", "cuda-bindings", "numpy")


def described() -> dict[str, str]:
    """Processor, system and versions, by what a table calls them."""
    return computer() | {package: installed(package) for package in PACKAGES}


def computer() -> dict[str, str]:
    return {
        "processor": processor(),
        "cores": str(len(os.sched_getaffinity(0))),
        "widest vectors": isa.widest(),
        "system": f"{platform.system()} {platform.machine()}, {'-'.join(platform.libc_ver())}",
        "Python": platform.python_version(),
        "gcc": gcc(),
        "date": datetime.now(UTC).date().isoformat(),
    }


def device_described() -> dict[str, str]:
    """The CUDA device of this machine, and what computes on it."""
    asked = "name,driver_version,memory.total"
    lines = output("nvidia-smi", f"--query-gpu={asked}", "--format=csv,noheader").splitlines()
    if not lines:
        raise SystemExit("nvidia-smi names no device, or is missing")
    found = dict(zip(("device", "driver", "its memory"), lines[0].split(", "), strict=True))
    release = re.search(r"release [\d.]+, V([\d.]+)", output("nvcc", "--version"))
    nvcc = release[1] if release else "none"
    return found | {"nvcc": nvcc} | computer() | {package: installed(package) for package in ON_DEVICE}


def output(command: str, *arguments: str) -> str:
    """What a command says; nothing if it is missing."""
    path = shutil.which(command)
    if path is None:
        return ""
    return subprocess.run([path, *arguments], capture_output=True, text=True, check=True).stdout


def processor() -> str:
    info = Path("/proc/cpuinfo")
    text = info.read_text(encoding="utf-8") if info.exists() else ""
    fields = dict(re.findall(r"^(model name|cpu family|model)\s*:\s*(.+)$", text, re.MULTILINE))
    if "model name" not in fields:
        return platform.processor() or "unknown"
    return f"{fields['model name']} (family {fields.get('cpu family')}, model {fields.get('model')})"


def gcc() -> str:
    return output("gcc", "-dumpfullversion").strip() or "none"


def installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"
