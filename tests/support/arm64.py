"""Kernels cross-compiled for arm64 and run by an emulator, in the place of those of this processor."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from llvmlite import binding

from hydroservo.engine import kernel, lanes, machine_code, rows
from hydroservo.engine.native import MachineCode
from tests.support.export.emulators import EMULATED, PATIENCE, run

ARM64 = EMULATED[0]
MAIN = """
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int32_t {name}({kinds});

static int64_t size[{count}];
static void *row[{count}];

int main(void)
{{
    for (int i = 0; i < {count}; i++) {{
        if (fread(&size[i], 8, 1, stdin) != 1)
            return 2;
        row[i] = calloc(size[i] + 1, 8);
        if (fread(row[i], 8, size[i], stdin) != (size_t)size[i])
            return 2;
    }}
    if ({name}({given}))
        return 1;
    for (int i = 0; i < {count}; i++)
        fwrite(row[i], 8, size[i], stdout);
    return 0;
}}
"""


class Arm64Kernel:
    """A kernel as ``Native`` is one; each call is a process, which reads the memory and writes it back."""

    def __init__(self, made: MachineCode, folder: Path) -> None:
        self.name, self.folder = made.name, folder
        self.object = folder / "kernel.o"
        self.object.write_bytes(made.code)

    def __call__(self, *arguments: Any) -> int:
        result = np.zeros(1, dtype=np.int64)
        given = (result, *arguments)
        program = self.folder / "kernel"
        if not program.exists():
            (self.folder / "main.c").write_text(self.main(given))
            run(self.folder, ARM64.compiler, "-static", "main.c", "kernel.o", "-o", program.name)
        rows = [np.atleast_1d(one) for one in given]
        sent = b"".join(np.int64(one.size).tobytes() + one.tobytes() for one in rows)
        done = subprocess.run(
            [*ARM64.emulator, program], input=sent, capture_output=True, timeout=PATIENCE, check=True
        )
        ends = np.cumsum([one.nbytes for one in rows])[:-1].tolist()
        found = np.split(np.frombuffer(done.stdout, dtype=np.uint8), ends)
        for one, content in zip(given, found, strict=True):
            if isinstance(one, np.ndarray):
                one[:] = content.view(one.dtype).reshape(one.shape)
        return int(result[0])

    def main(self, given: tuple[Any, ...]) -> str:
        """The program that calls it with arguments of such kinds."""
        kinds = [C_TYPES.get(type(one), "void *") for one in given]
        passed = [f"row[{i}]" if "*" in kind else f"*({kind} *)row[{i}]" for i, kind in enumerate(kinds)]
        return MAIN.format(name=self.name, kinds=", ".join(kinds), given=", ".join(passed), count=len(given))


C_TYPES = {int: "int64_t", float: "double"}


def kernels_for_arm64(patch: pytest.MonkeyPatch, folder: Path, cpu: str, features: str) -> list[Arm64Kernel]:
    """Let all kernels be compiled for a processor and run there; returns those made since."""
    ARM64.need()
    made: list[Arm64Kernel] = []

    def native(_: Any, make: Callable[[], MachineCode]) -> Arm64Kernel:
        place = folder / str(len(made))
        place.mkdir()
        made.append(Arm64Kernel(make(), place))
        return made[-1]

    patch.setenv("HYDROSERVO_CPU_FEATURES", features)
    patch.setattr(machine_code, "processor", lambda: processor(cpu, features))
    for maker in (kernel, lanes, rows):
        patch.setattr(maker, "native", native)
    return made


def processor(cpu: str, features: str) -> binding.TargetMachine:
    """A processor, with the options of ``machine_code.processor``."""
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    return binding.Target.from_triple("aarch64-unknown-linux-gnu").create_target_machine(
        cpu=cpu, features=features, opt=3, codemodel="jitdefault", jit=True
    )
