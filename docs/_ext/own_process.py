"""Has each page's cells executed from a process of its own.

Sphinx reads and writes pages in processes that it forks, several pages in each. What talks to a Jupyter
kernel does so over sockets that must not be in a process when it forks, nor outlive their page in it. As a
program, this executes the notebook that a path names, in place, in the current folder.
"""

import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from jupyter_cache.executors.utils import ExecutionResult
from myst_nb.core.execute import direct
from nbclient.exceptions import CellExecutionError
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

FAILED = 3  # and not 1, with which Python itself ends after an error


def executed(nb: Any, cwd: str, timeout: int, allow_errors: bool, **_: Any) -> ExecutionResult:
    """Execute a notebook in place, as the function of jupyter-cache that this replaces."""
    began = time.monotonic()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "page.ipynb"
        nbformat.write(nb, path)
        options = [str(path), str(timeout), str(int(allow_errors))]
        done = subprocess.run(
            [sys.executable, __file__, *options], cwd=cwd, check=False, capture_output=True, text=True
        )
        made = nbformat.read(path, nb.nbformat)
        nb.cells, nb.metadata = made.cells, made.metadata  # its language, which only the kernel knows
    seconds = time.monotonic() - began
    if done.returncode == 0:
        return ExecutionResult(nb, cwd, seconds)
    if done.returncode != FAILED:
        raise RuntimeError(f"cells were not executed:\n{done.stderr}")
    return ExecutionResult(nb, cwd, seconds, CellExecutionError(done.stderr, "cell", "failed"), done.stderr)


def setup(app: Sphinx) -> ExtensionMetadata:
    direct.single_nb_execution = executed
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def main(path: str, timeout: str, allow_errors: str) -> int:
    from nbclient import NotebookClient

    nb = nbformat.read(path, nbformat.NO_CONVERT)
    client = NotebookClient(nb, timeout=int(timeout), allow_errors=bool(int(allow_errors)))
    try:
        client.execute(cwd=".")
    except CellExecutionError as error:
        print(error, file=sys.stderr)
        return FAILED
    finally:
        nbformat.write(nb, path)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
