"""Many questions at once: Holm's correction."""

from collections.abc import Sequence

import numpy as np


def corrected(chances: Sequence[float]) -> list[float]:
    """Chances, corrected so that below a level is at most that share of studies with any false one.

    In rising order the i-th of m is min(1, max over j <= i of (m - j + 1) p(j)).

    Args:
        chances: of each finding where there is nothing, in any order.

    Source: Holm 1979, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6, 65-70.
    """
    plain = np.asarray(chances, dtype=np.float64)
    order = np.argsort(plain, kind="stable")
    scaled = plain[order] * np.arange(plain.size, 0, -1)
    found = np.empty_like(plain)
    found[order] = np.minimum(np.maximum.accumulate(scaled), 1.0) if plain.size else scaled
    return [float(one) for one in found]
