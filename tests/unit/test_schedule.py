"""The order of instructions in long blocks."""

from random import Random

import numpy as np
import pytest

from hydroservo.engine.machine_code import parse_module, schedule

HEAD = """\
define double @f(ptr %0, double %x) {
entry:
  br label %loop

loop:                                             ; preds = %entry
  %first.pre-phi = phi double [ %x, %entry ]
"""
END = "  br label %1\n\n1:                ; preds = %loop\n  ret double %last\n}\n"


def module(body: list[str]) -> str:
    return HEAD + "".join(f"  {line}\n" for line in body) + END


def body_of(text: str) -> list[str]:
    lines = text.splitlines()
    return [line.strip() for line in lines[6 : lines.index("  br label %n1")]]


def test_the_longest_way_to_the_end_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydroservo.engine.machine_code.LONG", 2)
    body = [
        "%a = fadd double %x, 1.0",
        "%b = fdiv double %first.pre-phi, 3.0",
        "%c = fdiv double %b, 3.0",
        "%last = fadd double %a, %c",
    ]
    text = schedule(module(body))
    parse_module(text)
    assert body_of(text) == [body[1], body[0], body[2], body[3]]


def test_reads_and_writes_of_memory_keep_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydroservo.engine.machine_code.LONG", 2)
    rng = np.random.default_rng(5)
    for _ in range(50):
        body = ["%last = fadd double %x, 1.0"]
        for i in range(20):
            kind = rng.integers(3)
            if kind == 0:
                body.append(f"%l{i} = load double, ptr %n0")
            elif kind == 1:
                body.append(f"store double {float(i)}, ptr %n0")
            else:
                body.append(f"%q{i} = fdiv double %x, {float(i + 1)}")
        lines = body_of(schedule(module(body).replace("%n0", "%0")))
        assert sorted(lines) == sorted(body)
        assert reads_of(lines) == reads_of(body)
        assert [line for line in lines if "store" in line] == [line for line in body if "store" in line]


def reads_of(body: list[str]) -> dict[str, int]:
    """After how many writes each read stands."""
    return {line: sum("store" in one for one in body[:i]) for i, line in enumerate(body) if "load" in line}


def test_operands_come_before_what_takes_them() -> None:
    random = Random(7)
    body = ["%v0 = fadd double %x, 1.0"]
    for i in range(1, 300):
        a, b = random.randrange(i), random.randrange(i)
        body.append(f"%v{i} = {random.choice(['fadd', 'fdiv', 'fmul'])} double %v{a}, %v{b}")
    body.append("%last = fadd double %v299, %v298")
    text = schedule(module(body))
    parse_module(text).verify()  # which refuses a value that is taken before it is there
    assert body_of(text) != body
    assert sorted(body_of(text)) == sorted(body)


def test_short_blocks_stay() -> None:
    body = ["%b = fdiv double %x, 3.0", "%last = fadd double %b, 1.0"]
    assert body_of(schedule(module(body))) == body
