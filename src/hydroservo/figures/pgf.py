"""A figure that LaTeX draws."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

from matplotlib.figure import Figure
from matplotlib.text import Text

from hydroservo.show.latex import escaped, label

MEASURED: Literal["center_baseline"] = "center_baseline"  # of numbers at an axis


@contextmanager
def drawn_by_latex(fig: Figure) -> Iterator[None]:
    """Inside, a figure that is saved as PGF needs nothing of LaTeX but ``pgf``.

    Matplotlib's own PGF needs commands of its own and the package ``underscore`` in the paper, leaves &, #
    and signs like a superscript five to LaTeX, which refuses them, and sets the numbers at an axis where they
    would end in the font that they were measured in, whatever the paper's.
    """
    from matplotlib.backends import backend_pgf

    usual = backend_pgf.RendererPgf

    class Renderer(usual):  # type: ignore[misc, valid-type]
        """Draws with text that LaTeX takes."""

        def draw_text(
            self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float, **options: Any
        ) -> None:
            shown = label(s) if options.get("ismath") else escaped(s)
            usual.draw_text(self, gc, x, y, shown, prop, angle, **options)  # type: ignore[no-untyped-call]

        def get_text_width_height_descent(self, s: str, prop: Any, ismath: Any) -> Any:
            shown = label(s) if ismath else escaped(s)
            return usual.get_text_width_height_descent(self, shown, prop, ismath)  # type: ignore[no-untyped-call]

    fig.draw_without_rendering()  # ticks are there only then
    measured = [one for one in fig.findobj(Text) if by_its_size(one)]
    for one in measured:
        one.set_verticalalignment("center")
    backend_pgf.RendererPgf = Renderer  # type: ignore[misc]
    try:
        yield
    finally:
        backend_pgf.RendererPgf = usual  # type: ignore[misc]
        for one in measured:
            one.set_verticalalignment(MEASURED)


def by_its_size(text: Any) -> bool:
    """Whether a text is placed by its measured size and not by its anchor."""
    return bool(text.get_verticalalignment() == MEASURED)
