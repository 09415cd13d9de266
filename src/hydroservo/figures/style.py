"""One look for every figure of the project, and one way to save it."""

import io
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import get_font_names
from matplotlib.legend import Legend
from matplotlib.text import Text

from hydroservo.core.errors import ParameterError
from hydroservo.core.outputs import atomic_path
from hydroservo.show.journal import TEX, FigureWidth
from hydroservo.show.table import latex_escaped, latex_label

MEASURED: Literal["center_baseline"] = "center_baseline"  # of numbers at an axis
# Source: Okabe and Ito, Color Universal Design, 2008; told apart with any common colour vision.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
COLOURS = {  # of controllers by their type, and of the demand
    "PI": PALETTE[0],
    "Backstepping": PALETTE[1],
    "TSMC": PALETTE[2],
    "demand": "#000000",
}
GREY = "#555555"  # of what stands aside
WIDTH = 6.3  # inch, the text width of an A4 page
RESOLUTION = 200  # dots per inch of a PNG
SHOWN = 110  # and of one in a notebook
METADATA: Mapping[str, tuple[str, str]] = {  # what would differ each time, and what may hold the origin
    ".png": ("Software", "Identifier"),
    ".svg": ("Date", "Identifier"),
    ".pdf": ("CreationDate", "Keywords"),
}
ENDINGS = (*METADATA, ".pgf")
ACROSS = 2  # panels in one column, side by side
SMALLER = 0.82  # text in a figure narrower than the page: 7 of 8.5 points
ROOM = 0.9  # of a figure, for its legend
TICKS = 8  # points, of numbers at axes
WIDE_FONTS = (  # on Linux, Windows and macOS
    *("Noto Sans CJK SC", "Noto Sans CJK JP", "WenQuanYi Zen Hei", "Microsoft YaHei", "Malgun Gothic"),
    *("PingFang SC", "Hiragino Sans GB", "Arial Unicode MS"),
)

RC: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # ships with matplotlib, so pictures are the same everywhere
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9,
    "xtick.labelsize": TICKS,
    "ytick.labelsize": TICKS,
    "legend.fontsize": 8,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.xmargin": 0.0,
    "axes.prop_cycle": cycler(color=PALETTE),
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "legend.borderaxespad": 0.3,
    "savefig.dpi": RESOLUTION,
    "svg.hashsalt": "hydroservo",
}


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
            shown = latex_label(s) if options.get("ismath") else latex_escaped(s)
            usual.draw_text(self, gc, x, y, shown, prop, angle, **options)  # type: ignore[no-untyped-call]

        def get_text_width_height_descent(self, s: str, prop: Any, ismath: Any) -> Any:
            shown = latex_label(s) if ismath else latex_escaped(s)
            return usual.get_text_width_height_descent(self, shown, prop, ismath)  # type: ignore[no-untyped-call]

    fig.draw_without_rendering()  # ticks are there only then
    measured = [one for one in fig.findobj(Text) if one.get_verticalalignment() == MEASURED]
    for one in measured:
        one.set_verticalalignment("center")
    backend_pgf.RendererPgf = Renderer  # type: ignore[misc]
    try:
        yield
    finally:
        backend_pgf.RendererPgf = usual  # type: ignore[misc]
        for one in measured:
            one.set_verticalalignment(MEASURED)


@contextmanager
def style(maths: bool = True) -> Iterator[None]:
    """What is drawn inside looks like the project's figures; matplotlib's settings are put back after it."""
    fonts = [*RC["font.sans-serif"], *wide_fonts()]
    with mpl.rc_context(RC | {"font.sans-serif": fonts, "text.parse_math": maths}):
        yield


@cache
def wide_fonts() -> list[str]:
    """The fonts of this machine that have the signs of Chinese, Japanese and Korean, for names in these."""
    known = set(get_font_names())
    return [name for name in WIDE_FONTS if name in known]


class Plot(Figure):
    """A figure that notebooks show, although it belongs to no window."""

    def _repr_png_(self) -> bytes:
        content = io.BytesIO()
        with style():
            self.savefig(content, format="png", dpi=SHOWN)
        return content.getvalue()

    def save(self, path: Path | str, *, width: FigureWidth | str | None = None, origin: str = "") -> Path:
        """Write it in the format that the file's ending names, as wide as a column of a journal if asked.

        The same figure always gives the same bytes. The metadata of the file hold its origin: as the
        identifier of a PNG or SVG, as a keyword of a PDF. A PGF, which LaTeX draws, has none.

        Args:
            path: ends in .png, .svg or .pdf; or in .pgf, where there is a LaTeX to measure its text.
            width: "one-column" or "two-column"; as it is if None. One with three panels side by side is as
                wide as two columns all the same. The figure keeps the width that it then has.
            origin: the hashes of the runs that it shows, for the metadata of the file.

        Raises:
            ParameterError: there is no such width or format.
            HydroservoError: the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() not in ENDINGS:
            raise ParameterError("path", str(path), f"must end in one of {', '.join(ENDINGS)}")
        if width is not None:
            if width not in [*FigureWidth]:
                raise ParameterError("width", width, f"must be one of {', '.join(FigureWidth)}")
            size = FigureWidth(width) if axes_across(self) <= ACROSS else FigureWidth.TWO_COLUMN
            with style():
                fit_width(self, size.width)
        with style(), atomic_path(path) as temporary:
            if path.suffix.lower() == ".pgf":
                system = next(filter(shutil.which, TEX), TEX[0])
                with mpl.rc_context({"pgf.texsystem": system, "pgf.rcfonts": False}), drawn_by_latex(self):
                    self.savefig(temporary)
            else:
                varies, holds = METADATA[path.suffix.lower()]
                self.savefig(temporary, metadata={varies: None, holds: f"hydroservo {origin}"})
        return path


def figure(height: float, width: float = WIDTH) -> Plot:
    """An empty figure of a size in inch; it belongs to no window and no global list of figures.

    Call it, and draw on it, inside :func:`style`.
    """
    return Plot(figsize=(width, height), layout="constrained")


def axes_across(fig: Figure) -> int:
    """How many panels side by side have a labelled axis each, and so need room."""
    across = {
        place.colspan.start
        for axis in fig.axes
        if axis.get_ylabel() and (place := axis.get_subplotspec()) is not None
    }
    return len(across)


def fit_width(fig: Figure, width: float) -> None:
    """Make a figure as wide as a journal wants it; its height stays, and text gets smaller in a narrow one.

    Call it inside :func:`style`.
    """
    if width < WIDTH <= fig.get_figwidth():
        fig.draw_without_rendering()  # ticks are there only then
        for text in fig.findobj(Text):
            if isinstance(text, Text):
                text.set_fontsize(SMALLER * float(text.get_fontsize()))
        for axis in fig.axes:
            axis.tick_params(labelsize=SMALLER * TICKS)
    fig.set_figwidth(width)
    for axis in fig.axes:
        if legend := axis.get_legend():
            fit_legend(fig, axis, legend)


def fit_legend(fig: Figure, axis: Axes, legend: Legend) -> None:
    """Put a legend that is wider than its figure above its panel, in fewer columns."""
    room = ROOM * fig.bbox.width
    width, texts = legend.get_window_extent().width, legend.get_texts()
    if width > room:
        axis.legend(
            [one for one in legend.legend_handles if one],
            [text.get_text() for text in texts],
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=max(int(len(texts) * room / width), 1),
            borderpad=0.1,
            fontsize=texts[0].get_fontsize(),
        )
