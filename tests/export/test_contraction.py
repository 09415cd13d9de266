"""The source itself keeps compilers from fusing products and sums, whatever they do by default."""

import re
import subprocess
from pathlib import Path

import pytest

from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.scenario import load_scenario
from tests.support.needs import needs
from tests.support.tiers import mostly
from tools.targets.sources import write_unit

FUSED = re.compile(r"\bv?fn?m[as]\w*\b")
M7 = ("-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16")
GCC_PRAGMA = r"#pragma GCC optimize.*\n"
PRAGMA = r"#pragma STDC FP_CONTRACT OFF\n"
# What may fuse: gcc's own default, and what clang does of its own where the processor can.
COMPILERS = [
    (("gcc", "-march=haswell"), GCC_PRAGMA),
    (("gcc", "-march=haswell", "-ffp-contract=fast", "-O3"), GCC_PRAGMA),
    (("gcc", "-march=sapphirerapids"), GCC_PRAGMA),
    (("clang", "-march=haswell"), PRAGMA),
]
CROSS = [
    (("arm-none-eabi-gcc", *M7), GCC_PRAGMA),
    (("aarch64-linux-gnu-gcc",), GCC_PRAGMA),
    (("aarch64-linux-gnu-gcc", "-march=armv8.2-a+fp16"), GCC_PRAGMA),  # FLT_EVAL_METHOD is 16, as before
    (("x86_64-w64-mingw32-gcc", "-march=haswell"), GCC_PRAGMA),
]


@pytest.fixture(scope="module")
def unit() -> CModule:
    loop = load_scenario("rig/1khz-tsmc-sine")
    return exported_unit(loop, Part.CONTROLLER, prefix="law", title="a law")


def fused(unit: CModule, command: tuple[str, ...], folder: Path) -> int:
    """How many instructions that multiply and add at once a compiler makes of a unit."""
    needs(command[0])
    source = write_unit(unit, folder)
    words = [*command[:1], "-std=gnu99", "-O2", "-Wall", "-Werror", *command[1:], "-S", source, "-o", "-"]
    text = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    return len(FUSED.findall(text))


@pytest.mark.parametrize(
    ("command", "pragma"),
    mostly(pytest.mark.nightly, [*COMPILERS, *CROSS], COMPILERS),
    ids=lambda one: "-".join(one) if type(one) is tuple else "",
)
def test_nothing_is_fused(unit: CModule, command: tuple[str, ...], pragma: str, tmp_path: Path) -> None:
    assert fused(unit, command, tmp_path) == 0
    assert fused(unit._replace(source=re.sub(pragma, "", unit.source)), command, tmp_path) > 0


@pytest.mark.parametrize(
    ("given", "status"), [(("-DFP_FAST_FMA",), 1), (("-DFP_FAST_FMA", "-DLAW_FUSES_NONE"), 0), ((), 0)]
)
def test_a_compiler_that_may_fuse_and_is_not_known_to_obey_is_refused(
    unit: CModule, given: tuple[str, ...], status: int, tmp_path: Path
) -> None:
    needs("gcc")
    words = ["gcc", "-U__GNUC__", *given, "-E", write_unit(unit, tmp_path), "-o", tmp_path / "law.i"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == status
    assert ("this compiler may fuse a*b + c" in done.stderr) == (status == 1)
