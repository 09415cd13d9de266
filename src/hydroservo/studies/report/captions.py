"""What is written below each picture of a study."""

from collections.abc import Callable, Mapping

from hydroservo.studies.report.findings import Findings

__all__ = ["CAPTIONS"]


def of_map(found: Findings) -> str:
    return (
        "Who wins where. A cell is a combination of conditions; its colour is the family of the law with "
        "the least error on the test conditions, the stronger the further the best law of any other family "
        "is behind. Grey is a tie, and the strip says between which families; the sign is the observer of "
        "the law with the least error. Hatched: every law loses more than "
        f"{percent(found.verdicts.rules.most_lost)} of its runs."
    )


def of_regret(found: Findings) -> str:
    near = f"{found.verdicts.rules.near_best:g}"
    return (
        "Regret: the error of each law over that of the best law of the cell. Cells lie as in the map. "
        f"Above each: in how many of the cells that any law masters it is within {near} of the best. Who "
        "must choose one law for all takes the one with the most blue. Pale grey: no law stays stable."
    )


def of_pairs(found: Findings) -> str:
    rules = found.verdicts.rules
    return (
        f"Each law against {found.reference}: ratio of errors on the same conditions, geometric mean over "
        f"all cells, with its {percent(rules.confidence)} interval over cells, not corrected for the number "
        f"of laws. Grey ties: the interval holds 1, or the ratio is nearer to 1 than {rules.margin:g} (the "
        "band). Lost runs are in no ratio; their shares are of the cells that any law masters."
    )


def of_factorial(found: Findings) -> str:
    return (
        f"Law by observer: the error of each pair over that of {found.reference}, with its interval over "
        "cells and its lost runs. Right: how much of what errors differ by within cells each factor "
        "explains beyond the others; the rest is interaction."
    )


def of_parts(_: Findings) -> str:
    return (
        "What each part is worth: the error of the law without it over that of the law with it, all cells. "
        "Right: in how many cells the part is needed, makes no difference that can be told, or does harm."
    )


def of_front(found: Findings) -> str:
    return (
        f"What error costs in command activity, in the cell {found.where(found.cell)}: each law with each "
        "weight of activity in what was searched. Named marks are on the front of error, activity and "
        "robustness; the line is the least error for an activity."
    )


def of_target(found: Findings) -> str:
    return (
        f"What error costs on the target, in the cell {found.where(found.cell)}: error against the "
        "operations with real numbers that a sample takes at most. The line is the least error for so many. "
        "Hollow marks have no margins: the loop switches, rises without bound or does not settle about any "
        "operating point looked at, or is unstable about one."
    )


def of_curves(found: Findings) -> str:
    return (
        f"Whether the search was long enough, in the cell {found.where(found.cell)}: error on test after so "
        "many candidates, median of the searches and the band of their quartiles. A law whose line still "
        "falls at the right end may be better than it is shown."
    )


def of_limit(found: Findings) -> str:
    return (
        f"How much is left to gain, in the cell {found.where(found.cell)}: error over the least that any "
        "command could leave that knows the future, geometric mean over the test conditions whose limits "
        "were sought; up to the grey line, the least of one that does not. Lines: quartiles of the searches."
    )


def percent(share: float) -> str:
    return f"{100.0 * share:g} %"


CAPTIONS: Mapping[str, Callable[[Findings], str]] = {
    "map": of_map,
    "regret": of_regret,
    "pairs": of_pairs,
    "factorial": of_factorial,
    "parts": of_parts,
    "front": of_front,
    "target": of_target,
    "curves": of_curves,
    "limit": of_limit,
}
