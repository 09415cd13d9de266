"""How the documentation is built; every number and picture in it is computed while it is."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

import hydroservo

HERE = Path(__file__).parent
TOOLS = HERE / "_ext"
sys.path.insert(0, str(TOOLS))
# Cells run in processes of their own, which read their modules from here too.
PLACES = [str(TOOLS), str(HERE.parent), os.environ.get("PYTHONPATH")]
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, PLACES))
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
os.environ |= {"COLUMNS": "96", "NO_COLOR": "1", "TERM": "dumb"}

project = "hydroservo"
author = "The hydroservo developers"
project_copyright = "The hydroservo developers"
release = version = hydroservo.__version__

extensions = [
    "blocks",
    "fields",
    "myst_nb",
    "own_process",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build", "_ext", "conf.py"]
nitpicky = True
nitpick_ignore_regex = [
    # Names of other libraries, whose inventories a build without a network cannot read.
    ("py:.*", r"(xr|xarray|pd|pandas|np|numpy|matplotlib|collections|pathlib|typing)\..*"),
    ("py:.*", r".*Annotated\[.*"),
    (
        "py:.*",
        r"(Path|Callable|Sequence|Mapping|Iterator|NDArray|ArrayLike|Figure|Any|Block|Runs|Records|optional)",
    ),
    (
        "py:.*",
        r"hydroservo\.(core\.(roles\.(saying\.)?BlockClass|formatting\.Scale)|linear\.(system\.System|operating_point\.OperatingPoint)|identification\.(segments\.UnderstoodLog|result\.FittedProblem)|show\.journal\.FigureWidth|studies\.law_standing\.(OF_LIMITS|CellLimit)|scenario\.(ranges\.Relative|parameter_draws\.Variation)|runs\.(step_sizes\.(RecordedSignals|RecordedRun)|trace\.Trace))",
    ),  # of signatures alone
]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
add_module_names = False

myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}  # the gallery: scripts, and pages
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 180
nb_execution_show_tb = True
nb_output_stderr = "remove"
nb_merge_streams = True
nb_render_markdown_format = "myst"
suppress_warnings = ["myst-nb.lexer"]  # of cells that are not executed

html_theme = "furo"
html_title = f"hydroservo {release}"
# MathJax from a package, so that the site needs no network. Its own extension would stop parallel builds.
MATHJAX = find_spec("sphinx-mathjax-offline")
html_static_path = ["_static", str(Path(MATHJAX.origin).parent / "static")]  # type: ignore[arg-type,union-attr]
mathjax_path = "mathjax/tex-chtml.js"
html_css_files = ["site.css"]
html_show_sourcelink = False
