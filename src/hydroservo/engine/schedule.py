"""Orders the instructions of long blocks in LLVM's text, so that a processor can overlap more of them.

LLVM keeps about the order of the source. Where one sample waits for the last, a processor that looks some
hundred instructions ahead then sees the longest chain alone, or what follows it alone.
"""

import re
from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import takewhile

LONG = 60  # instructions of a block that is worth it
RATE = 1.5  # instructions a cycle that start beside the longest chain
BLOCK = re.compile(r"(?:^  .*\n)+", re.MULTILINE)
UNNAMED = re.compile(r"%(\d+)\b|^(\d+)(?=:)", re.MULTILINE)
NAME = re.compile(r"%[-$.\w]+")
INSTRUCTION = re.compile(r"  (?:%[-$.\w]+ = )?(?:tail |notail |musttail )?(\w+)")
PURE = "sqrt|fma|fabs|copysign|floor|ceil|rint|trunc|minnum|maxnum|[su](?:min|max)"
INTRINSIC = re.compile(rf"@llvm\.({PURE})\b")
TERMINATORS = {"br", "ret", "switch", "unreachable"}
CYCLES = {  # from operands to result, about those of processors since 2018
    **dict.fromkeys(("fadd", "fsub", "fmul", "fcmp"), 3.0),
    **dict.fromkeys(("sitofp", "uitofp", "fptosi", "load"), 5.0),
    **dict.fromkeys(("bitcast", "getelementptr"), 0.0),
    **{"fdiv": 13.0, "call": 4.0, "sqrt": 21.0, "fma": 4.0, "minnum": 2.0, "maxnum": 2.0, "select": 2.0},
}


def schedule(module: str) -> str:
    """The text of a module whose long blocks begin what leads to their ends by the longest way first.

    Results keep their bits: nothing but the order of instructions changes, and none that reads or writes
    memory passes a write.
    """
    named = UNNAMED.sub(lambda number: f"%n{number[1]}" if number[1] else f"n{number[2]}", module)
    return BLOCK.sub(lambda block: order_block(block[0]), named)


def order_block(block: str) -> str:
    """The lines of a block, what stands between its phis and its terminator in another order."""
    lines = block.splitlines(keepends=True)
    first = sum(1 for _ in takewhile(lambda line: operation_of(line) == "phi", lines))
    last = next((i for i, line in enumerate(lines) if operation_of(line) in TERMINATORS), len(lines))
    body = lines[first:last]
    if len(body) < LONG:
        return block
    order = start_order(dependencies(body), list(map(latency, body)))
    return "".join([*lines[:first], *(body[i] for i in order), *lines[last:]])


def operation_of(line: str) -> str:
    """The operation of an instruction."""
    found = INSTRUCTION.match(line)
    return found[1] if found else ""


def latency(line: str) -> float:
    """How long an instruction's result takes."""
    intrinsic = INTRINSIC.search(line)
    return CYCLES.get(intrinsic[1] if intrinsic else operation_of(line), 1.0)


def dependencies(body: Sequence[str]) -> list[set[int]]:
    """For each instruction the earlier ones that must come before it."""
    places: dict[str, int] = {}
    needs: list[set[int]] = []
    reads: list[int] = []
    writes: list[int] = []  # the last one
    for i, line in enumerate(body):
        before = {places[name] for name in NAME.findall(line) if name in places}
        operation = operation_of(line)
        if operation == "load":
            before.update(writes)
            reads.append(i)
        elif operation == "store" or (operation == "call" and not INTRINSIC.search(line)):
            before.update(reads, writes)
            reads, writes = [], [i]
        needs.append(before)
        if " = " in line:
            places[line.split(maxsplit=1)[0]] = i
    return needs


def start_order(needs: Sequence[set[int]], durations: Sequence[float]) -> list[int]:
    """The order in which instructions start: of those that can, the one with the longest way to the end."""
    followers: list[list[int]] = [[] for _ in needs]
    for i, before in enumerate(needs):
        for earlier in before:
            followers[earlier].append(i)
    way = list(durations)
    for i in reversed(range(len(way))):
        way[i] += max((way[later] for later in followers[i]), default=0.0)
    missing, possible = list(map(len, needs)), [0.0] * len(way)
    order: list[int] = []
    waiting = [(0.0, i) for i, count in enumerate(missing) if not count]
    ready: list[tuple[float, int]] = []
    now = 0.0
    while waiting or ready:
        while waiting and (not ready or waiting[0][0] <= now):
            at, i = heappop(waiting)
            now = max(now, at)
            heappush(ready, (-way[i], i))
        _, i = heappop(ready)
        order.append(i)
        for later in followers[i]:
            missing[later] -= 1
            possible[later] = max(possible[later], now + durations[i])
            if not missing[later]:
                heappush(waiting, (possible[later], later))
        now += 1.0 / RATE if durations[i] else 0.0
    return order
