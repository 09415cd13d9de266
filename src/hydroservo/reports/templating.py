"""The templates of pages: one frame for all, and what each puts into it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import jinja2


def environment(package: str) -> "jinja2.Environment":
    """The templates in a package's folder ``templates``, which may extend ``frame.html.j2``.

    The frame has the page's look, in the light, in the dark and in print, and refers to no other file. What
    is put into a template is escaped, and a name that is not there is an error.

    Args:
        package: such as ``hydroservo.reports``.
    """
    import jinja2

    places = dict.fromkeys([package, "hydroservo.reports"])
    return jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(place) for place in places]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
