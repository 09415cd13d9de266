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

__all__ = ["described"]

PACKAGES = ("hydroservo", "numba", "numpy", "scipy", "jax", "diffrax", "casadi", "control")


def described() -> dict[str, str]:
    """Processor, system and versions, by what a table calls them."""
    found = {
        "processor": processor(),
        "cores": str(len(os.sched_getaffinity(0))),
        "widest vectors": isa.widest(),
        "system": f"{platform.system()} {platform.machine()}, {'-'.join(platform.libc_ver())}",
        "Python": platform.python_version(),
        "gcc": gcc(),
        "date": datetime.now(UTC).date().isoformat(),
    }
    return found | {package: installed(package) for package in PACKAGES}


def processor() -> str:
    info = Path("/proc/cpuinfo")
    text = info.read_text(encoding="utf-8") if info.exists() else ""
    fields = dict(re.findall(r"^(model name|cpu family|model)\s*:\s*(.+)$", text, re.MULTILINE))
    if "model name" not in fields:
        return platform.processor() or "unknown"
    return f"{fields['model name']} (family {fields.get('cpu family')}, model {fields.get('model')})"


def gcc() -> str:
    command = shutil.which("gcc")
    if command is None:
        return "none"
    done = subprocess.run([command, "-dumpfullversion"], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"
