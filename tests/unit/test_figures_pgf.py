"""Figures that LaTeX draws: what is a formula, and what is shown as typed."""

import pytest
from matplotlib.backends import backend_pgf
from matplotlib.figure import Figure

from hydroservo.figures.style import drawn_by_latex


class Recorder:
    """Draws nothing, and keeps what it is given."""

    def __init__(self):
        self.texts = []

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        self.texts.append(s)

    def get_text_width_height_descent(self, s, prop, ismath):
        self.texts.append(s)
        return 1.0, 1.0, 0.0


@pytest.mark.parametrize(
    ("text", "ismath", "expected"), [("a$b$c", False, r"a\$b\$c"), (r"a $b_1$ \$c", True, r"a $b_1$ \$c")]
)
def test_only_formulas_are_formulas(monkeypatch, text, ismath, expected):
    monkeypatch.setattr(backend_pgf, "RendererPgf", Recorder)
    with drawn_by_latex(Figure()):
        renderer = backend_pgf.RendererPgf()
        renderer.draw_text(None, 0.0, 0.0, text, None, 0.0, ismath=ismath, mtext=None)
        renderer.get_text_width_height_descent(text, None, ismath)
    assert renderer.texts == [expected, expected]
