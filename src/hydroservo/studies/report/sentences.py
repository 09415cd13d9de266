"""What a study says, in sentences."""

import math
from collections import Counter
from collections.abc import Sequence
from statistics import fmean

from hydroservo.core.formatting import counted, enumeration, number
from hydroservo.studies.fronts import STILL
from hydroservo.studies.law_pairs import ErrorRatio
from hydroservo.studies.report.tables import motion_kind
from hydroservo.studies.report.view import StudyView, interval_text, is_sure, level_text

MOST = 3  # names in a row
WIDE = 10.0  # an end of an interval over the other, from which it says nothing


def lead_sentence(found: StudyView) -> str:
    """Which laws are best at the activity that is shown."""
    return f"A{level_text(found)[1:]}, {winners_text(found)}."


def sentences(found: StudyView) -> list[str]:
    """What else is to be said: at which activity, how much, how surely, at what price."""
    others = [found._replace(level=level) for level in found.verdicts.levels if level != found.level]
    parts = [
        *(lead_sentence(one) for one in others),
        search_sentence(found),
        f"All that follows is {level_text(found)}.",
        nearest_sentence(found),
        reference_sentence(found),
        lost_runs_sentence(found),
        hunting_sentence(found),
        target_sentence(found),
        margins_sentence(found),
        factors_sentence(found),
        *worth_sentences(found),
        *sensor_sentences(found),
        *limit_sentences(found),
    ]
    return [part for part in parts if part]


def winners_text(found: StudyView) -> str:
    """Which laws are best in how many cells, and in how many of them surely."""
    cells, every = found.at.cells.values(), len(found.verdicts.activity)
    if not cells:
        return "no law has so low an activity in any cell"
    best = Counter(cell.best.law for cell in cells if cell.best.law)
    if not best:
        return "every law loses too many runs in every cell"
    first, *others = best.most_common(MOST)
    parts = [f"{law} in {count}{surely_text(found, law)}" for law, count in others]
    rest = sum(best.values()) - first[1] - sum(count for _, count in others)
    parts += [f"others in {rest}"] if rest else []
    text = f"{first[0]} is best in {first[1]} of {counted(every, 'cell')}{surely_text(found, first[0])}"
    text = f"{text}, {enumeration(parts)}" if parts else text
    lost, lively = len(cells) - sum(best.values()), every - len(cells)
    text = f"{text}; in {lost} every law loses too many runs" if lost else text
    return f"{text}; in {lively} no law has so low an activity" if lively else text


def surely_text(found: StudyView, law: str) -> str:
    """In how many cells a law is best and no other ties with it, in brackets; empty for none."""
    alone = sum(cell.best.ties == [law] for cell in found.at.cells.values())
    return f" (in {alone} surely)" if alone else ""


def nearest_sentence(found: StudyView) -> str:
    """The law that is near the best most often."""
    areas = {law: area for law, area in found.at.areas.items() if law in found.laws and area.cells > 1}
    if len(areas) < 2:
        return ""
    law = max(areas, key=lambda one: (areas[one].near_best, -areas[one].lost, -areas[one].largest))
    area = areas[law]
    near = round(area.near_best * area.cells)
    largest = (
        f", and at most {number(area.largest)} times the best where it stays" if area.largest > 1.0 else ""
    )
    lost = f" It loses too many runs in {round(area.lost * area.cells)} of them." if area.lost else ""
    return (
        f"{law} is within {found.verdicts.rules.near_best:g} times the best in {near} of the "
        f"{counted(area.cells, 'cell')} that have a best law, and no other law in more{largest}.{lost}"
    )


def reference_sentence(found: StudyView) -> str:
    """How many laws are surely better and worse than the reference over all cells."""
    ratios = {law: found.to_reference(law) for law in found.laws if law != found.reference}
    known = {law: ratio for law, ratio in ratios.items() if not math.isnan(ratio.value)}
    if not known:
        return ""
    rules = found.verdicts.rules
    less = sorted(
        (law for law in known if is_sure(known[law], rules) and known[law].value < 1.0),
        key=lambda law: known[law].value,
    )
    more = [law for law in known if is_sure(known[law], rules) and known[law].value > 1.0]
    ties = len(known) - len(less) - len(more)
    better = f"{len(less)} {'is' if len(less) == 1 else 'are'} surely better than {found.reference}"
    worse = f"{len(more)} {'is' if len(more) == 1 else 'are'} surely worse"
    counts = f"{better}, {ties} {'ties' if ties == 1 else 'tie'} and {worse}"
    best = [f"{law} ({interval_text(known[law])})" for law in less[:MOST]]
    furthest = f" Furthest ahead: {enumeration(best)}." if best else ""
    unknown = len(ratios) - len(known)
    others = f" {counted(unknown, 'law')} cannot be compared in every cell." if unknown else ""
    return f"Over all cells, of {counted(len(known), 'law')} {counts}.{furthest}{others}"


def lost_runs_sentence(found: StudyView) -> str:
    """How many test runs were lost, and by whom in the cells with a best law."""
    runs, lost, losing = 0, 0, set()
    for cell in found.at.cells.values():
        for law, one in cell.standings.items():
            runs += one.conditions
            lost += one.lost.lost
            losing |= {law} if one.lost.lost and cell.best.law else set()
    if not lost:
        return f"No law lost any of the {runs:,} test runs."
    total = f"{lost:,} of the {runs:,} test runs were lost"
    if not losing:
        return f"{total}, all in cells in which every law loses too many."
    ends = sorted((found.lost(law), law) for law in losing)
    named = [f"{number(100.0 * share, 2)} % ({law})" for share, law in (ends[0], ends[-1])]
    by = (
        f"{counted(len(losing), 'law')} lost from {named[0]} to {named[1]} of their runs"
        if len(losing) > 1
        else f"{ends[0][1]} lost {number(100.0 * ends[0][0], 2)} % of its runs"
    )
    return f"{total}; in the cells with a best law {by}, and all others none."


def hunting_sentence(found: StudyView) -> str:
    """In how many pairs of law and cell some test runs oscillate for good."""
    shares = [one.hunting for cell in found.at.cells.values() for one in cell.standings.values()]
    known = [one for one in shares if not math.isnan(one)]
    if not known:
        return ""
    some, most = sum(one > 0.0 for one in known), max(known)
    if not some:
        return f"No command oscillates for good in any of the {len(known)} pairs of law and cell."
    return (
        f"In {some} of {counted(len(known), 'pair')} of law and cell the command oscillates for good in some "
        f"test runs, in at most {number(100.0 * most, 2)} % of them."
    )


def target_sentence(found: StudyView) -> str:
    """What the winners of cells take on the target against the reference."""
    ratios = []
    for cell in found.at.cells.values():
        own, other = cell.properties.get(cell.best.law), cell.properties.get(found.reference)
        counts = [one.target.operations for one in (own, other) if one]
        if len(counts) == 2 and all(counts) and cell.best.law != found.reference:
            ratios.append(counts[0] / counts[1])  # type: ignore[operator]
    if not ratios:
        return ""
    return (
        f"On the target the best law takes {ratio_range_text(ratios)} the operations of a sample that "
        f"{found.reference} takes, in {counted(len(ratios), 'cell')}."
    )


def margins_sentence(found: StudyView) -> str:
    """How many loops have margins, and how small those of winners are."""
    cells = found.at.cells.values()
    known = [one.margins for cell in cells for one in cell.properties.values()]
    if not known:
        return ""
    kinds = Counter(map(motion_kind, known))
    best = [cell.properties[cell.best.law].margins for cell in cells if cell.best.law in cell.properties]
    peaks = [one.sensitivity_peak for one in best if one.stable]
    ends = " to ".join(dict.fromkeys(number(one) for one in (min(peaks), max(peaks)))) if peaks else ""
    least = f" Where the best law has margins, its max |S| is {ends}." if ends else ""
    return (
        f"In small motions {kinds['rough']} of the {counted(len(known), 'pair')} of law and cell are not "
        f"linear, and {kinds['unstable']} unstable, about the operating points looked at.{least}"
    )


def factors_sentence(found: StudyView) -> str:
    """What differences between laws are owed to."""
    known = {name: one for name, one in found.at.effects.items() if not math.isnan(one.share)}
    if not known or not found.rows():
        return ""
    ordered = sorted(known.items(), key=lambda one: -one[1].share)
    parts = [f"the {name} explains {share_text(one.share, one.low, one.high)}" for name, one in ordered]
    beyond = ", each beyond the others" if len(parts) > 1 else ""
    return (
        f"Of what errors differ by within cells {enumeration(parts)}{beyond}; the rest is interaction, and "
        "what the combinations tried cannot tell apart."
    )


def worth_sentences(found: StudyView) -> list[str]:
    """What parts of laws earn."""
    lines = []
    for one in found.at.worths.values():
        ratio = one.over_cells
        if not is_narrow_interval(ratio):
            continue
        tie = not is_sure(ratio, found.verdicts.rules)
        harm = "it does harm" if ratio.value < 1.0 else "it earns its place"
        cells = counted(one.wins + one.ties + one.losses, "cell")
        lines.append(
            f"Without {one.part} the error of {one.whole} is {interval_text(ratio)} times as large: "
            f"{'it earns nothing that can be told' if tie else harm} (needed in {one.wins}, a tie in "
            f"{one.ties}, better without in {one.losses} of {cells})."
        )
    return lines


def sensor_sentences(found: StudyView) -> list[str]:
    words = {"V": "velocity or position alone", "VP": "load pressure too", "VPX": "the spool's place too"}
    lines = []
    for name, ratio in found.at.prices.items():
        without, _, with_it = name.partition(" over ")
        if is_narrow_interval(ratio):
            lines.append(
                f"Sensors: the best law with {words[without]} has {interval_text(ratio)} times the error of "
                f"the best with {words[with_it]}."
            )
    return lines


def limit_sentences(found: StudyView) -> list[str]:
    """How far the best are from the least that is possible, and what the limits leave open."""
    cells = found.at.cells.values()
    best = [cell.limit.laws[cell.best.law] for cell in cells if cell.best.law in cell.limit.laws]
    own = [one for one in best if not math.isnan(one.clairvoyant)]
    said = []
    if own:
        lost, runs = sum(one.lost for one in own), sum(one.runs for one in own)
        clairvoyant = ratio_range_text([one.clairvoyant for one in own])
        causal = ratio_range_text([one.causal for one in own])
        said.append(
            f"The best law of a cell leaves {clairvoyant} the least error of any "
            f"command that knows the future, and {causal} that of one to which "
            f"jumps are known once they are there, on the {counted(runs, 'run')} of conditions whose limits "
            f"were sought{f', without {lost} that were lost' if lost else ''}."
        )
    still = sum(cell.limit.open for cell in cells)
    if still:
        said.append(
            f"Of {counted(still, 'condition')} the search for the limit did not end; they do not count."
        )
    below = sum(cell.limit.below for cell in cells)
    if below:
        said.append(
            f"{counted(below, 'run')} left less than the clairvoyant limit, whose search then ended in an "
            "optimum that is not the best of all."
        )
    return said


def search_sentence(found: StudyView) -> str:
    """How still the fronts are, at all levels of activity."""
    moved = [one.moved for own in found.verdicts.fronts.values() for one in own.values()]
    if not moved:
        return ""
    still = sum(one < STILL for one in moved)
    return (
        f"The last half of the candidates moved fronts by {100.0 * fmean(moved):.1f} % on average and "
        f"{100.0 * max(moved):.0f} % at most; {still} of {len(moved)} moved by less than {100.0 * STILL:g} %."
    )


def is_narrow_interval(ratio: ErrorRatio) -> bool:
    """Whether a ratio is known well enough for a sentence: its interval is less than a decade."""
    return ratio.low > 0.0 and ratio.high < WIDE * ratio.low


def share_text(value: float, low: float, high: float) -> str:
    """A share with its interval, in percent."""
    ends = "" if math.isnan(low) else f" [{100.0 * max(low, 0.0):.0f}, {100.0 * max(high, 0.0):.0f}]"
    return f"{100.0 * max(value, 0.0):.0f} %{ends}"


def ratio_range_text(ratios: Sequence[float]) -> str:
    low, high = number(min(ratios)), number(max(ratios))
    return f"{low} times" if low == high else f"{low} to {high} times"
