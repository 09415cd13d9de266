"""What a study says, in sentences."""

import math
from collections import Counter
from collections.abc import Sequence

from hydroservo.formatting import number
from hydroservo.studies.ablation import Ratio
from hydroservo.studies.report.findings import Findings, sure
from hydroservo.studies.report.property_tables import kind_of

__all__ = ["interval", "lead", "listed", "sentences"]

MOST = 3  # names in a row


def lead(found: Findings) -> str:
    """Who wins how often."""
    cells = found.verdicts.cells.values()
    wins = Counter(cell.best.families[0] for cell in cells if cell.best.state == "won").most_common()
    ties = sum(cell.best.state == "tie" for cell in cells)
    none = sum(cell.best.state == "none" for cell in cells)
    won = [f"{family} {'wins ' if not place else ''}{count}" for place, (family, count) in enumerate(wins)]
    parts = [listed(won)] if won else []
    parts += [f"{ties} {'is a tie' if ties == 1 else 'are ties'} between families"] if ties else []
    parts += [f"in {none} no law stays stable"] if none else []
    return f"Of {counted(len(cells), 'cell')} {'; '.join(parts)}."


def sentences(found: Findings) -> list[str]:
    """What else is to be said: where, how much, how surely, at what price."""
    parts = [
        *where_won(found),
        nearest_to_best(found),
        against_reference(found),
        lost_runs(found),
        price(found),
        on_target(found),
        margins(found),
        factors(found),
        *worths(found),
        *sensors(found),
        *limits(found),
        search(found),
    ]
    return [part for part in parts if part]


def where_won(found: Findings) -> list[str]:
    """For each family that wins cells: what these have in common, and by how much it wins."""
    said = []
    for family in found.families:
        cells = {
            name: cell.best
            for name, cell in found.verdicts.cells.items()
            if cell.best.state == "won" and cell.best.families == [family]
        }
        if cells:
            margins = [best.margin for best in cells.values() if best.next_family]
            by = f", by {span(margins)} over the next family" if margins else ""
            said.append(f"{family} wins {common_levels(found, list(cells))}{by}.")
    return said


def common_levels(found: Findings, cells: Sequence[str]) -> str:
    """Where some cells lie: on each axis the levels they have, if these are not all."""
    parts = []
    for axis in found.grid.axes:
        met = {found.grid.cells[cell][axis.name] for cell in cells}
        if len(met) < len(axis.levels):
            labels = [level.label for level in axis.levels if level.name in met]
            parts.append(f"{axis.label} = {listed(labels, 'or')}")
    inside = sum(
        all(
            levels[axis.name] in {found.grid.cells[cell][axis.name] for cell in cells}
            for axis in found.grid.axes
        )
        for levels in found.grid.cells.values()
    )
    where = f"where {'; '.join(parts)}" if parts else "on all levels of every axis"
    return f"{where} ({len(cells)} of the {counted(inside, 'cell')} there)"


def nearest_to_best(found: Findings) -> str:
    """The law that is near the best most often."""
    areas = {law: area for law, area in found.verdicts.areas.items() if law in found.laws and area.cells}
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
        f"{law} is within {found.verdicts.rules.near_best:g} of the best in {near} of the {area.cells} "
        f"cells that any law masters, and no other more often{largest}.{lost}"
    )


def against_reference(found: Findings) -> str:
    """How many laws are surely better and worse than the reference over all cells."""
    ratios = {law: found.to_reference(law) for law in found.laws if law != found.reference}
    known = {law: ratio for law, ratio in ratios.items() if not math.isnan(ratio.value)}
    if not known:
        return ""
    rules = found.verdicts.rules
    less = sorted(
        (law for law in known if sure(known[law], rules) and known[law].value < 1.0),
        key=lambda law: known[law].value,
    )
    more = [law for law in known if sure(known[law], rules) and known[law].value > 1.0]
    ties = len(known) - len(less) - len(more)
    counts = f"{len(less)} surely better, {ties} {'ties' if ties == 1 else 'tie'}, {len(more)} surely worse"
    best = [f"{law} ({interval(known[law])})" for law in less[:MOST]]
    named = f" Least error: {listed(best)}." if best else ""
    return f"Over all cells, against {found.reference}: of {counted(len(known), 'law')} {counts}.{named}"


def lost_runs(found: Findings) -> str:
    """How many test runs were lost, and by whom in the cells that any law masters."""
    runs, lost, losing = 0, 0, set()
    for cell in found.verdicts.cells.values():
        for law, one in cell.standings.items():
            runs += one.searches * one.conditions
            lost += one.lost.lost
            losing |= {law} if one.lost.lost and cell.best.law else set()
    if not lost:
        return f"No law lost any of the {runs:,} test runs."
    total = f"{lost:,} of the {runs:,} test runs were lost"
    if not losing:
        return f"{total}, all in cells that no law masters."
    ends = sorted((found.lost(law), law) for law in losing)
    named = [f"{number(100.0 * share, 2)} % ({law})" for share, law in (ends[0], ends[-1])]
    by = (
        f"{counted(len(losing), 'law')} lost from {named[0]} to {named[1]} of their runs"
        if len(losing) > 1
        else f"{ends[0][1]} lost {number(100.0 * ends[0][0], 2)} % of its runs"
    )
    return f"{total}; in the cells that any law masters {by}, and all others none."


def price(found: Findings) -> str:
    """What the winners of cells pay in command activity against the reference."""
    ratios = []
    for cell in found.verdicts.cells.values():
        own, other = cell.standings.get(cell.best.law), cell.standings.get(found.reference)
        if own and other and other.activity > 0.0 and cell.best.law != found.reference:
            ratios.append(own.activity / other.activity)
    ratios = [one for one in ratios if math.isfinite(one)]
    if not ratios:
        return ""
    return (
        f"Price: the law with the least error moves the command {span(ratios)} as much as "
        f"{found.reference}, in {counted(len(ratios), 'cell')}."
    )


def on_target(found: Findings) -> str:
    """What the winners of cells take on the target against the reference."""
    ratios = []
    for cell in found.verdicts.cells.values():
        own, other = cell.properties.get(cell.best.law), cell.properties.get(found.reference)
        counts = [one.target.operations for one in (own, other) if one]
        if len(counts) == 2 and all(counts) and cell.best.law != found.reference:
            ratios.append(counts[0] / counts[1])  # type: ignore[operator]
    if not ratios:
        return ""
    return (
        f"On the target the law with the least error takes {span(ratios)} the operations of a sample that "
        f"{found.reference} takes, in {counted(len(ratios), 'cell')}."
    )


def margins(found: Findings) -> str:
    """How many loops have margins, and how small those of winners are."""
    cells = found.verdicts.cells.values()
    known = [one.margins for cell in cells for one in cell.properties.values()]
    if not known:
        return ""
    kinds = Counter(map(kind_of, known))
    best = [cell.properties[cell.best.law].margins for cell in cells if cell.best.law in cell.properties]
    peaks = [one.sensitivity_peak for one in best if one.stable]
    ends = " to ".join(dict.fromkeys(number(one) for one in (min(peaks), max(peaks)))) if peaks else ""
    least = f" Where the law with the least error has margins, its max |S| is {ends}." if ends else ""
    return (
        f"In small motions {kinds['rough']} of the {counted(len(known), 'pair')} of law and cell are not "
        f"linear, and {kinds['unstable']} unstable, about the operating points looked at.{least}"
    )


def factors(found: Findings) -> str:
    """What differences between laws are owed to."""
    known = {name: one for name, one in found.verdicts.effects.items() if not math.isnan(one.share)}
    if not known or not found.rows():
        return ""
    ordered = sorted(known.items(), key=lambda one: -one[1].share)
    parts = [f"the {name} explains {share(one.share, one.low, one.high)}" for name, one in ordered]
    beyond = ", each beyond the others" if len(parts) > 1 else ""
    return f"Of what errors differ by within cells {listed(parts)}{beyond}; the rest is how they go together."


def worths(found: Findings) -> list[str]:
    """What parts of laws earn."""
    said = []
    for one in found.verdicts.worths.values():
        ratio = one.over_cells
        if math.isnan(ratio.value):
            continue
        tie = not sure(ratio, found.verdicts.rules)
        harm = "it does harm" if ratio.value < 1.0 else "it earns its place"
        cells = counted(one.wins + one.ties + one.losses, "cell")
        said.append(
            f"Without {one.part} the error of {one.whole} is {interval(ratio)} times as large: "
            f"{'it earns nothing that can be told' if tie else harm} (needed in {one.wins}, a tie in "
            f"{one.ties}, better without in {one.losses} of {cells})."
        )
    return said


def sensors(found: Findings) -> list[str]:
    """What sensors are worth."""
    words = {"V": "velocity or position alone", "VP": "load pressure too", "VPX": "the spool's place too"}
    said = []
    for name, ratio in found.verdicts.prices.items():
        without, _, with_it = name.partition(" over ")
        if not math.isnan(ratio.value):
            said.append(
                f"Sensors: the best law with {words[without]} has {interval(ratio)} times the error of the "
                f"best with {words[with_it]}."
            )
    return said


def limits(found: Findings) -> list[str]:
    """How far the best are from the least that is possible, and what the limits leave open."""
    cells = found.verdicts.cells.values()
    best = [cell.limit.laws[cell.best.law] for cell in cells if cell.best.law in cell.limit.laws]
    own = [one for one in best if not math.isnan(one.clairvoyant)]
    said = []
    if own:
        lost, runs = sum(one.lost for one in own), sum(one.runs for one in own)
        said.append(
            f"The best law of a cell leaves {span([one.clairvoyant for one in own])} the least error of any "
            f"command that knows the future, and {span([one.causal for one in own])} that of one to which "
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


def search(found: Findings) -> str:
    """How many laws a longer search might still have helped."""
    falls, count = 0, 0
    for cell in found.verdicts.cells.values():
        for stages in cell.curves.values():
            ends = [stage.error for stage in stages if math.isfinite(stage.error)]
            if len(ends) > 1:
                count += 1
                falls += ends[-1] * found.verdicts.rules.margin < ends[-2]
    if not count:
        return ""
    return (
        f"In {falls} of {count} pairs of law and cell the last step of the budget still lowered the error "
        f"by more than a factor of {found.verdicts.rules.margin:g}."
    )


def interval(ratio: Ratio) -> str:
    """A ratio with its interval, such as ``0.83 [0.76, 0.90]``."""
    return f"{number(ratio.value)} [{number(ratio.low)}, {number(ratio.high)}]"


def share(value: float, low: float, high: float) -> str:
    """A share with its interval, in percent."""
    ends = "" if math.isnan(low) else f" [{100.0 * max(low, 0.0):.0f}, {100.0 * max(high, 0.0):.0f}]"
    return f"{100.0 * max(value, 0.0):.0f} %{ends}"


def span(ratios: Sequence[float]) -> str:
    """The range of some ratios."""
    low, high = number(min(ratios)), number(max(ratios))
    return f"{low} times" if low == high else f"{low} to {high} times"


def counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def listed(parts: Sequence[str], last: str = "and") -> str:
    """Parts as they stand in a sentence."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}" if parts else ""
