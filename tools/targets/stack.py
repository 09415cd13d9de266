"""The stack that a function takes at most, from the graph of calls that gcc writes beside an object."""

import re
from pathlib import Path

OPTIONS = ("-fcallgraph-info=su",)
NODE = re.compile(r'^node: { title: "([^"]+)" label: "[^"]*?(?:\\n(\d+) bytes \((\w+)\))?"', re.MULTILINE)
EDGE = re.compile(r'^edge: { sourcename: "([^"]+)" targetname: "([^"]+)"', re.MULTILINE)


def deepest(graph: Path, function: str) -> int:
    """Bytes of a function and the deepest chain of calls below it.

    Functions that the graph does not hold, such as the libraries', count nothing.

    Raises:
        ValueError: a stack whose size the compiler does not know, a recursion, or no such function.
    """
    text = graph.read_text(encoding="utf-8")
    frames: dict[str, int] = {}
    for name, size, kind in NODE.findall(text):
        if kind not in {"", "static"}:
            raise ValueError(f"the stack of {name} is {kind}")
        frames[name] = int(size or 0)
    if function not in frames:
        raise ValueError(f"{graph.name} has no {function}")
    calls: dict[str, set[str]] = {}
    for caller, called in EDGE.findall(text):
        calls.setdefault(caller, set()).add(called)

    def depth(name: str, above: tuple[str, ...]) -> int:
        if name in above:
            raise ValueError(f"{name} calls itself")
        below = (depth(called, (*above, name)) for called in calls.get(name, ()))
        return frames[name] + max(below, default=0)

    return depth(function, ())
