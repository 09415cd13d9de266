"""What is written below each picture of a study."""

from collections.abc import Callable, Mapping

from hydroservo.studies.report.findings import Findings


def of_fronts(found: Findings) -> str:
    return (
        "What error costs in command activity: the fronts of all laws in each cell, on test conditions; "
        "errors far above the reference's are cut off. Both axes are over "
        f"{found.reference} at its own activity: the calmest of its gains that tie with its least error. The "
        "heading gives both. Bands are intervals of the ratio on the same conditions."
    )


def of_map(found: Findings) -> str:
    return (
        "Who wins where, and at what activity. A cell is a combination of conditions; its colour is the "
        "family of the best law on the test conditions, of those that are calm enough, the stronger the "
        "further the best law of any other family is behind. Grey is a tie, and the strip says between which "
        "families; the sign is the observer of the best law. Hatched: every law loses more than "
        f"{percent(found.verdicts.rules.most_lost)} of its runs. Empty: no law is so calm."
    )


def of_factorial(found: Findings) -> str:
    return (
        f"Law by observer, {level_text(found)}: the error of each pair over that of {found.reference}, with "
        "its interval over cells and its lost runs. Right: how much of what errors differ by within cells "
        "each factor explains beyond the others; the rest is interaction, and what the combinations tried "
        "cannot tell apart."
    )


def of_parts(found: Findings) -> str:
    return (
        f"What each part is worth, {level_text(found)}: the error of the law without it over that of the law "
        "with it, all cells. Right: in how many cells the part is needed, makes no difference that can be "
        "told, or does harm."
    )


def of_target(found: Findings) -> str:
    return (
        f"What error costs on the target, in the cell {found.where(found.cell)}, {level_text(found)}: error "
        "against the operations with real numbers that a sample takes at most. The line is the least error "
        "for so many. Hollow marks have no margins: the loop switches, rises without bound or does not "
        "settle about any operating point looked at, or is unstable about one."
    )


def of_limit(found: Findings) -> str:
    return (
        f"How much is left to gain, in the cell {found.where(found.cell)}, {level_text(found)}: error over "
        "the least that any command could leave that knows the future, geometric mean over the test "
        "conditions whose limits were sought; up to the grey line, the least of one that does not. Lines: "
        "intervals over conditions."
    )


def level_text(found: Findings) -> str:
    """The level that is shown, in words."""
    if found.level == "1":
        return f"at {found.reference}'s own activity"
    return f"at {found.level} times {found.reference}'s activity"


def percent(share: float) -> str:
    return f"{100.0 * share:g} %"


CAPTIONS: Mapping[str, Callable[[Findings], str]] = {
    "fronts": of_fronts,
    "map": of_map,
    "factorial": of_factorial,
    "parts": of_parts,
    "target": of_target,
    "limit": of_limit,
}
