"""Has each page's cells executed from a process of its own.

Sphinx reads and writes pages in processes that it forks, several pages in each. What talks to a Jupyter
kernel does so over sockets that must not be in a process when it forks, nor outlive their page in it: each
page's conversation is in one more fork, which ends with it.
"""

import logging
import time
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbclient
import nbformat
from jupyter_cache.executors.utils import ExecutionResult
from myst_nb.core.execute import direct
from nbclient.exceptions import CellExecutionError
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata
from traitlets.config import Config


def executed(nb: Any, cwd: str, timeout: int, allow_errors: bool, **_: Any) -> ExecutionResult:
    """Execute a notebook in place, as the function of jupyter-cache that this replaces."""
    began = time.monotonic()
    with TemporaryDirectory() as folder:
        path, error = Path(folder) / "page.ipynb", Path(folder) / "error.txt"
        nbformat.write(nb, path)
        child = get_context("fork").Process(target=execute, args=(path, error, cwd, timeout, allow_errors))
        child.start()
        child.join()
        if child.exitcode:
            raise RuntimeError(f"cells were not executed: exit status {child.exitcode}")
        made = nbformat.read(path, nb.nbformat)
        nb.cells, nb.metadata = made.cells, made.metadata  # its language, which only the kernel knows
        said = error.read_text("utf-8") if error.exists() else None
    seconds = time.monotonic() - began
    if said is None:
        return ExecutionResult(nb, cwd, seconds)
    return ExecutionResult(nb, cwd, seconds, CellExecutionError(said, "cell", "failed"), said)


def execute(path: Path, error: Path, cwd: str, timeout: int, allow_errors: bool) -> None:
    """Execute the notebook of a path in place; a cell's failure is left in a file."""
    logging.disable(logging.INFO)  # Sphinx shows what a logger says, and nbclient's says each notebook
    nb = nbformat.read(path, nbformat.NO_CONVERT)
    # No network between page and kernel; an absolute path, for they stand in two folders.
    sockets = Config({"ConnectionFileMixin": {"transport": "ipc", "ip": str(path.with_name("kernel"))}})
    client = nbclient.NotebookClient(nb, timeout=timeout, allow_errors=allow_errors, config=sockets)
    try:
        client.execute(cwd=cwd)
    except CellExecutionError as failure:
        error.write_text(str(failure), "utf-8")
    finally:
        nbformat.write(nb, path)


def setup(app: Sphinx) -> ExtensionMetadata:
    direct.single_nb_execution = executed
    return {"parallel_read_safe": True, "parallel_write_safe": True}
