"""Reads a MATLAB file in a process of its own: scipy's reader may crash on a damaged one.

    python -P mat_process.py FILE

Standard output is an archive of numpy's with each row of numbers, and the unit of each that has one.
"""

import io
import sys

import numpy as np
from scipy.io import loadmat

__all__: list[str] = []


def main(path: str) -> None:
    table = loadmat(path, squeeze_me=True, simplify_cells=True)
    units = table.get("units", {}) if isinstance(table.get("units"), dict) else {}
    rows = {name: one for name, one in table.items() if isinstance(one, np.ndarray) and one.ndim == 1}
    names = np.array([[name, str(units.get(name, ""))] for name in rows], dtype=str).reshape(-1, 2)
    file = io.BytesIO()
    plain = [one if one.dtype.kind in "fiub" else one.astype(str) for one in rows.values()]
    np.savez(file, *plain, names=names, allow_pickle=False)
    sys.stdout.buffer.write(file.getvalue())


if __name__ == "__main__":
    main(sys.argv[1])
