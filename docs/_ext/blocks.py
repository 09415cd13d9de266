"""The directive ``blocks``: documents the classes of a package that play some roles, with their states.

::

    .. blocks:: hydroservo.control.controllers
       :roles: Controller Limiter
       :wrappers: without

``wrappers`` keeps apart the blocks that nest another of their own role: ``with`` or ``without`` others.
"""

from collections.abc import Iterator
from importlib import import_module
from typing import ClassVar, get_type_hints

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.parsing import nested_parse_to_nodes
from sphinx.util.typing import ExtensionMetadata, OptionSpec

from hydroservo.scenario.role_checks import declared_roles


def which(text: str | None) -> bool:
    return directives.choice(text, ("with", "without")) == "with"


class Blocks(SphinxDirective):
    """Writes an autoclass for each."""

    required_arguments = 1
    option_spec: ClassVar[OptionSpec] = {"roles": str.split, "wrappers": which}

    def run(self) -> list[nodes.Node]:
        package = self.arguments[0]
        lines = [f".. autoclass:: {package}.{cls.__name__}" for cls in self.classes(package)]
        where, _ = self.get_source_info()
        return nested_parse_to_nodes(self.state, StringList(lines, where))

    def classes(self, package: str) -> Iterator[type]:
        """The blocks in the order of their names, each with the records that its file declares besides."""
        module = import_module(package)
        every = [cls for name in module.__all__ if isinstance(cls := getattr(module, name), type)]
        wrapping = self.options.get("wrappers")
        for cls in every:
            roles = declared_roles(cls)
            wraps = any(role in get_type_hints(cls).values() for role in roles)
            if {role.__name__ for role in roles} & set(self.options["roles"]) and wrapping in (None, wraps):
                yield cls
                yield from (
                    one for one in every if one.__module__ == cls.__module__ and not declared_roles(one)
                )


def setup(app: Sphinx) -> ExtensionMetadata:
    app.add_directive("blocks", Blocks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
