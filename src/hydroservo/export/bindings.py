"""Which names of a Python function stand for one value, and which change."""

import ast
from collections.abc import Iterator, Sequence

__all__ = ["bound_names", "changing_names", "loop_names"]


def bound_names(tree: ast.AST) -> list[str]:
    """Every name that a function assigns to, once, in the order of the text."""
    found = [
        node for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    ]
    return list(
        dict.fromkeys(node.id for node in sorted(found, key=lambda node: (node.lineno, node.col_offset)))
    )


def changing_names(tree: ast.FunctionDef) -> set[str]:
    """The names that need a variable: assigned to more than once, or in a block and used outside of it.

    The name _ is none of them, as each value under it stands alone, nor is that of a loop's own number.
    """
    bound: dict[str, list[tuple[int, ...]]] = {argument.arg: [()] for argument in tree.args.args}
    read: dict[str, list[tuple[int, ...]]] = {}
    for node, block in located(tree.body, ()):
        if isinstance(node, ast.Name):
            (bound if isinstance(node.ctx, ast.Store) else read).setdefault(node.id, []).append(block)
        if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name):
            bound.setdefault(node.target.id, []).append(block)
    found = set()
    for name, blocks in bound.items():
        outside = any(where[: len(blocks[0])] != blocks[0] for where in read.get(name, []))
        if len(blocks) > 1 or outside:
            found.add(name)
    return found - {"_"} - loop_names(tree)


def loop_names(tree: ast.AST) -> set[str]:
    """The names of the numbers that loops count with."""
    targets = (node.target for node in ast.walk(tree) if isinstance(node, ast.For))
    return {target.id for target in targets if isinstance(target, ast.Name)}


def located(nodes: Sequence[ast.stmt], block: tuple[int, ...]) -> Iterator[tuple[ast.AST, tuple[int, ...]]]:
    """Every node with the block of statements that it stands in, a path of numbers."""
    for node in nodes:
        inner = [part for name in ("body", "orelse") for part in [getattr(node, name, [])] if part]
        statements = {id(one) for part in inner for one in part}
        pending: list[ast.AST] = [node]
        while pending:
            one = pending.pop()
            yield one, block
            pending += [child for child in ast.iter_child_nodes(one) if id(child) not in statements]
        for part in inner:
            yield from located(part, (*block, id(part[0])))
