"""A study's manifest and table, made up: no loop is simulated.

Six error dynamics with three observers each, and three laws without a part, in twelve cells; one of the cells
is so hard that no law stays stable in it. Each law has a front of five points in each cell.
"""

import json
import math
from itertools import product

import numpy as np
import pandas as pd

from hydroservo.studies.search import COLUMNS

FAMILIES = {
    "PI": 0.30,
    "Backstepping": 0.22,
    "TSMC": 0.06,
    "LQ": 0.0,
    "ADRC": 0.12,
    "STW": 0.05,
}  # log of error
OBSERVERS = {"HGDO": 0.10, "ESO": 0.02, "Kalman": 0.0}
WITHOUT = {"terminal powers": 0.01, "disturbance estimate": 0.35, "reaching law": 0.08}  # of TSMC with Kalman
AXES = {
    "rate": ("sample period h ωₕ", {"fast": "0.05", "middle": "0.3", "slow": "1.0"}),
    "noise": ("noise / amplitude [%]", {"low": "0.1", "high": "2"}),
    "valve": ("valve lag τ ωₕ", {"quick": "0.3", "lagging": "3"}),
}
HARDEST = {"rate": "slow", "noise": "high", "valve": "lagging"}
POINTS = (
    -0.9,
    -0.45,
    0.0,
    0.6,
    1.2,
)  # of a front: logarithms of its activity over what the law is at home with
SPLITS = {"train": 4, "validation": 6, "test": 16}
SCALES = (1.0, 1.5, 2.0, 3.0)
LIMITED = 4  # test conditions of each cell


def made_up_manifest():
    """What ``study.json`` holds."""
    laws = {
        f"{family}+{observer}": law_of(family, observer) for family, observer in product(FAMILIES, OBSERVERS)
    }
    laws |= {f"TSMC+Kalman without {part}": law_of("TSMC", "Kalman", part) for part in WITHOUT}
    cells = {
        "-".join(levels): dict(zip(AXES, levels, strict=True))
        for levels in product(*(levels for _, levels in AXES.values()))
    }
    axes = [
        {
            "name": name,
            "label": label,
            "levels": [
                {"name": level, "label": text, "value": float(text)} for level, text in levels.items()
            ],
        }
        for name, (label, levels) in AXES.items()
    ]
    manifest = {
        "format": 1,
        "hydroservo": "0.0.0",
        "title": "Six laws with three observers on a velocity servo",
        "axes": axes,
        "cells": cells,
        "laws": laws,
        "limits": {"conditions": LIMITED},
        "metric": "rms error",
        "unit": "m/s",
        "reference": "PI+ESO",
        "kinds": ["sine", "square"],
        "conditions": {**SPLITS, "stress": list(SCALES)},
        "search": {"candidates": 1024, "seeds": 1, "levels": [0.5, 1.0, 2.0]},
    }
    return json.loads(json.dumps(manifest, sort_keys=True))


def law_of(family, observer, without=""):
    gains = 2 + 2 * list(FAMILIES).index(family)
    return {
        "family": family,
        "observer": observer,
        "wrapper": "",
        "class": "V" if family == "PI" else "VP",
        "gains": gains,
        "of": f"{family}+{observer}" if without else "",
        "without": without,
    }


def part_of(manifest, laws, cells):
    """A smaller study: some of the laws in some of the cells."""
    kept = {"laws": laws, "cells": cells}
    return manifest | {key: {name: manifest[key][name] for name in names} for key, names in kept.items()}


def write_conditions(manifest, folder):
    """What a study's folder holds of its conditions."""
    for cell in manifest["cells"]:
        each = {str(i): {"kind": "sine", "set": {"truth.plant.mass": 4.0 + i}} for i in range(SPLITS["test"])}
        file = folder / "conditions" / f"{cell}.json"
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps({"test": each}), "utf-8")


def made_up_table(manifest=None, seed=1):
    """All parts of the study as one table, made of a few factors and noise."""
    manifest = manifest or made_up_manifest()
    parts = [
        part(manifest, law, cell, np.random.default_rng([seed, a, b]))
        for a, law in enumerate(manifest["laws"])
        for b, cell in enumerate(manifest["cells"])
    ]
    return pd.concat(parts, ignore_index=True)


def made_up_limits(table):
    """Limits of the first test conditions of a study's cells: half of what any law leaves there at best.

    The search for the last one of each cell did not end.
    """
    tests = table[(table["split"] == "test") & (table["condition"] < LIMITED) & ~table["lost"]]
    least = tests.groupby(["cell", "condition"])["error"].min().reset_index()
    clairvoyant = 0.5 * least.pop("error")
    ended = least["condition"] < LIMITED - 1
    return least.assign(clairvoyant=clairvoyant, causal=1.4 * clairvoyant, converged=ended)


def part(manifest, law, cell, random):
    """One unit: the front of a law in a cell."""
    conditions = [(split, i, math.nan) for split, count in SPLITS.items() for i in range(count)]
    conditions += [("stress", i, scale) for i, scale in enumerate(SCALES)]
    rows = pd.DataFrame(product(range(len(POINTS)), conditions), columns=["point", "where"])
    split, condition, scale = zip(*rows.pop("where"), strict=True)
    rows = rows.assign(split=split, condition=np.array(condition, np.int64), scale=scale)
    level, risk, restless = truth(manifest["laws"][law], manifest["cells"][cell])
    common = np.random.default_rng([99, list(manifest["cells"]).index(cell)]).normal(0.0, 0.25, 1000)
    lively = np.array(POINTS)[rows["point"]]
    hard = np.nan_to_num(rows["scale"].to_numpy(), nan=1.0)
    error = 1e-3 * np.exp(
        level
        + common[rows["condition"] + 100 * rows["split"].map([*SPLITS, "stress"].index)]
        - 0.3 * lively
        + 0.3 * (hard - 1.0)
        + random.normal(0.0, 0.04, len(rows))
    )
    lost = np.tile(random.random(len(conditions)), len(POINTS)) < np.where(
        hard > 1.0, np.minimum(risk + 0.12 * (hard - 1.0) * level**2, 1.0), risk
    )
    swing = np.where(rows["split"] == "test", np.where(rows["condition"] == 5, 0.2, 0.0), np.nan)
    gains = [json.dumps({"controller.gain": round(10.0 * math.exp(one), 3)}) for one in POINTS]
    rows = rows.assign(
        law=law,
        cell=cell,
        search_seed=0,
        candidates=1024,
        moved=0.004 + 0.01 * (manifest["laws"][law]["family"] == "TSMC"),
        error=np.where(lost, math.inf, error),
        activity=restless * np.exp(lively + random.normal(0.0, 0.02, len(rows))),
        swing=swing,
        lost=lost,
        parameters=np.array(gains)[rows["point"]],
    )
    return rows[list(COLUMNS)]


def truth(law, cell):
    """What the law comes to in the cell: log of its error, risk of a lost run, command activity in %/s."""
    slow, noisy, lag = (
        {"fast": 0.0, "middle": 0.5, "slow": 1.0}[cell["rate"]],
        float(cell["noise"] == "high"),
        float(cell["valve"] == "lagging"),
    )
    switching = law["family"] in ("TSMC", "STW")
    level = 0.2 + FAMILIES[law["family"]] + OBSERVERS[law["observer"]] + 0.6 * slow + 0.4 * noisy + 0.3 * lag
    level += switching * (0.5 * slow + 0.25 * noisy - 0.25) - (law["family"] == "ADRC") * (0.3 * noisy - 0.05)
    level -= (law["family"] == "PI") * 0.45 * noisy * slow
    level += WITHOUT.get(law["without"], 0.0) + (law["observer"] == "HGDO") * 0.2 * noisy
    risk = 0.03 * switching * noisy * slow
    if cell == HARDEST:
        risk = 0.6
    return level, risk, 40.0 * math.exp(1.2 * noisy + 0.9 * switching - 0.3 * (law["family"] == "PI"))
