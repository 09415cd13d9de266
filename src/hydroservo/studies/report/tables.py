"""The tables of a study's report: each law over all cells, and the laws of a cell."""

import math
from collections import Counter
from collections.abc import Iterable
from statistics import fmean

from hydroservo.show import Cell, Column, Mark, Table
from hydroservo.show.table import CellValue
from hydroservo.studies.cell_verdict import CellVerdict
from hydroservo.studies.law_pairs import ErrorRatio, pair_between, ratio_between
from hydroservo.studies.properties import LawMargins
from hydroservo.studies.report.view import StudyView, interval_text, level_text

DIGITS = 3
ACTIVITY = Column("activity", "%/s", DIGITS)
KINDS = {"linear": "linear", "rough": "not linear", "unstable": "unstable"}  # of loops, in words
MARKS = {"rough": Mark.QUIET, "unstable": Mark.DOUBTFUL}
COUNTS = ("operations", "divisions", "roots", "functions", "state", "parameters")


def interval_columns(heading: str, unit: str = "", digits: int = DIGITS) -> list[Column]:
    """A number and the ends of its interval."""
    return [Column(f"{heading}{end}", unit, digits) for end in ("", " low", " high")]


def range_columns(heading: str, unit: str = "") -> list[Column]:
    """The least and the largest of some numbers."""
    return [Column(f"{heading} {end}", unit, digits=2) for end in ("from", "to")]


def count_columns(*headings: str) -> list[Column]:
    return [Column(heading, digits=DIGITS) for heading in headings]


def row_cells(values: Iterable[CellValue], mark: Mark | None = None) -> list[Cell]:
    """A row of a table whose columns have the units."""
    return [Cell(value, mark=mark) for value in values]


def known_interval(value: float, low: float, high: float) -> ErrorRatio:
    """A number and its interval; nan throughout where there is no number."""
    return ErrorRatio(value, low, high) if math.isfinite(value) else ErrorRatio(*[math.nan] * 3)


def known_range(values: Iterable[float]) -> tuple[float, float]:
    """The least and the largest of some numbers; nan where there are none."""
    numbers = [value for value in values if not math.isnan(value)]
    return (min(numbers), max(numbers)) if numbers else (math.nan, math.nan)


def to_decibels(ratio: float) -> float:
    return 20.0 * math.log10(ratio)


def ordered_laws_in(found: StudyView, cell: str) -> list[str]:
    """The laws of a cell, the one with the least error first, those that lose too many runs last."""
    standings, most = found.at.cells[cell].standings, found.verdicts.rules.most_lost

    def place(law: str) -> tuple[bool, float]:
        one = standings[law]
        return one.lost.value > most, math.inf if math.isnan(one.error) else one.error

    return sorted(standings, key=place)


def front_table(found: StudyView) -> Table:
    columns = [
        *(Column("cell"), Column("law"), Column("level"), ACTIVITY),
        *interval_columns("error", found.unit),
        *interval_columns("ratio"),
    ]
    points = [
        (cell, law, one)
        for cell, own in found.verdicts.fronts.items()
        for law, (some, _) in own.items()
        for one in some
    ]
    rows = [row_cells((cell, law, one.level, *one[:4], *one.ratio)) for cell, law, one in points]
    return Table(
        "fronts",
        columns,
        rows,
        "The fronts of all laws on test conditions.",
        "Level: the smallest at which these gains are taken. Ratio: of the error to that of "
        f"{found.reference} at its own activity.",
    )


COLUMNS = (
    *(Column("law"), Column("small motions")),
    *count_columns("linear points", "points", "gain reduction margin", "gain margin"),
    *(Column("phase margin", "rad", DIGITS), Column("delay margin", "s", DIGITS)),
    *(Column("disk margin", digits=DIGITS), Column("max |S|", "dB", DIGITS)),
    *count_columns(*COUNTS[:4], "bytes of state", "bytes of parameters"),
)

STATES = {"best": "best", "tie": "ties", "behind": "behind", "out": "out"}
WITHOUT_MARGINS = ("rough", "unstable")
PRICES = (
    Column("law"),
    *range_columns("activity"),
    *range_columns("hunting", "%"),
    *range_columns("max |S|", "dB"),
    *count_columns(*(KINDS[kind] for kind in WITHOUT_MARGINS), "operations", "bytes"),
)


def property_table(found: StudyView, name: str) -> Table:
    """The margins and the price of each of a cell's laws."""
    properties = found.at.cells[name].properties
    rows = [
        [
            Cell(law),
            *margin_cells(properties[law].margins),
            *row_cells(count_or_nan(getattr(properties[law].target, one)) for one in COUNTS),
        ]
        for law in ordered_laws_in(found, name)
        if law in properties
    ]
    return Table(
        f"properties-{name}", COLUMNS, rows, f"{found.where(name)}. Margins and price on the target."
    )


def motion_kind(one: LawMargins) -> str:
    """What a law's loop is in small motions: linear, rough or unstable."""
    if not one.linear:
        return "rough"
    return "linear" if one.stable else "unstable"


def margin_cells(one: LawMargins) -> list[Cell]:
    kind = motion_kind(one)
    margins = (
        *(one.gain_reduction_margin, one.gain_margin, one.phase_margin, one.delay_margin, one.disk_margin),
        to_decibels(one.sensitivity_peak),
    )
    values = margins if kind == "linear" else [math.nan] * len(margins)
    return [Cell(KINDS[kind], mark=MARKS.get(kind)), *row_cells((one.linear, one.points, *values))]


def count_or_nan(value: int | None) -> float:
    return math.nan if value is None else value


def largest_price(found: StudyView, law: str, *prices: str) -> float:
    """The largest sum of some prices of a law in any cell; nan where one is unknown."""
    targets = [cell.properties[law].target for cell in found.at.cells.values() if law in cell.properties]
    sums = [sum(count_or_nan(getattr(one, price)) for price in prices) for one in targets]
    return max(sums) if sums and not any(map(math.isnan, sums)) else math.nan


def law_tables(found: StudyView) -> list[Table]:
    """Each law over all cells at the level that is shown."""
    laws, level = ordered_laws(found), level_text(found)
    beside = f"over that of {found.reference} at its own activity"
    return [
        Table(
            f"laws-{found.level}",
            law_columns(found),
            [row_cells(law_row(found, law)) for law in laws],
            f"Each law over all cells, {level}.",
            f"Error: {beside}, with its interval.",
        ),
        Table(
            f"prices-{found.level}",
            PRICES,
            [row_cells(price_row(found, law)) for law in laws],
            f"What each law takes, {level}.",
            f"Ranges are over cells. Activity: {beside}.",
        ),
    ]


def ordered_laws(found: StudyView) -> list[str]:
    """The laws, those with the least error over all cells first."""
    ratios = {law: found.to_reference(law) for law in found.manifest["laws"]}
    return sorted(ratios, key=lambda law: (math.isnan(ratios[law].value), ratios[law]))


def law_columns(found: StudyView) -> list[Column]:
    """After the error over all conditions, that under each kind of them."""
    return [
        *(Column("law"), Column("sensors"), Column("gains")),
        *interval_columns("error"),
        *count_columns(*kinds_of(found), *STATES.values(), "no gains"),
        Column("lost runs", "%", digits=2),
    ]


def kinds_of(found: StudyView) -> list[str]:
    """The kinds of conditions; none where there is only one."""
    kinds = [str(kind) for kind in found.manifest["kinds"]]
    return kinds if len(kinds) > 1 else []


def law_row(found: StudyView, law: str) -> list[CellValue]:
    about = found.manifest["laws"][law]
    own = [cell for cell in found.at.cells.values() if law in cell.standings]
    states = Counter(state_in(cell, law) for cell in own)
    return [
        *(law, str(about["class"]), about.get("gains", math.nan)),
        *known_interval(*found.to_reference(law)),
        *(kind_ratio(found, law, k) for k in range(len(kinds_of(found)))),
        *(states[state] for state in STATES),
        len(found.verdicts.activity) - len(own),
        100.0 * found.lost(law),
    ]


def state_in(cell: CellVerdict, law: str) -> str:
    """How a law stands in a cell: best alone, tie with the best, behind it, or out."""
    if law in cell.best.ties:
        return "best" if cell.best.ties == [law] else "tie"
    return "out" if math.isinf(cell.regret[law]) or not cell.best.law else "behind"


def kind_ratio(found: StudyView, law: str, kind: int) -> float:
    """A law's error over that of the reference at its own activity, under one kind of conditions."""
    ratios = [cell.kinds[law][kind] for cell in found.at.cells.values() if law in cell.kinds]
    if len(ratios) < len(found.verdicts.activity) or not all(one > 0.0 for one in ratios):
        return math.nan
    return math.exp(fmean(map(math.log, ratios)))


def price_row(found: StudyView, law: str) -> list[CellValue]:
    own = {name: cell for name, cell in found.at.cells.items() if law in cell.standings}
    bases = {name: found.reference_standing(name).activity for name in own}
    margins = [cell.properties[law].margins for cell in own.values() if law in cell.properties]
    kinds = Counter(map(motion_kind, margins))
    return [
        law,
        *known_range(own[name].standings[law].activity / base for name, base in bases.items() if base > 0.0),
        *known_range(100.0 * cell.standings[law].hunting for cell in own.values()),
        *known_range(to_decibels(one.sensitivity_peak) for one in margins if one.stable),
        *(kinds[kind] if margins else math.nan for kind in WITHOUT_MARGINS),
        *(largest_price(found, law, "operations"), largest_price(found, law, "state", "parameters")),
    ]


LIMITS = (
    Column("law"),
    *interval_columns("over clairvoyant limit"),
    *count_columns("over causal limit", "lost runs", "runs"),
)


def cell_tables(found: StudyView, name: str) -> list[Table]:
    """The tables of a cell at the level that is shown; of limits and properties where they are known."""
    tables = [cell_table(found, name)]
    cell = found.at.cells[name]
    if cell.limit.conditions:
        laws = [(law, cell.limit.laws[law]) for law in ordered_laws_in(found, name)]
        rows = [row_cells((law, *known_interval(*one[:3]), *one[3:])) for law, one in laws]
        tables.append(Table(f"limits-{name}", LIMITS, rows, f"{found.where(name)}. Errors over the limits."))
    if cell.properties:
        tables.append(property_table(found, name))
    return tables


def cell_table(found: StudyView, name: str) -> Table:
    """Each law of a cell, the best one first."""
    best = found.at.cells[name].best
    marks = {**dict.fromkeys(best.ties, Mark.GOOD), best.law: Mark.BEST}
    return Table(
        f"cell-{name}",
        cell_columns(found),
        [row_cells(cell_row(found, name, law), marks.get(law)) for law in ordered_laws_in(found, name)],
        f"{found.where(name)}. {winner_text(found, name)}.",
        best="law; verdicts say which tie with it",
    )


def cell_columns(found: StudyView) -> list[Column]:
    return [
        *(Column("law"), Column("verdict")),
        *interval_columns("error", found.unit),
        *count_columns("over best", "alone low", "alone high"),
        Column("Holm's chance", digits=2),
        Column("tail", found.unit, DIGITS),
        *interval_columns("lost runs", "%", digits=2),
        *(ACTIVITY, Column("hunting", "%", digits=2), Column("survives")),
        *(Column("sensors"), Column("rank")),
    ]


def cell_row(found: StudyView, name: str, law: str) -> list[CellValue]:
    cell = found.at.cells[name]
    one, lost = cell.standings[law], cell.standings[law].lost
    return [
        *(law, verdict_text(found, name, law)),
        *known_interval(one.error, one.error_low, one.error_high),
        *beside_best(found, name, law),
        one.tail,
        *(100.0 * share for share in (lost.value, lost.low, lost.high)),
        *(one.activity, 100.0 * one.hunting, one.survived),
        *(str(found.manifest["laws"][law]["class"]), cell.ranks[law] if cell.best.law else math.nan),
    ]


def beside_best(found: StudyView, name: str, law: str) -> list[float]:
    """A law's error over that of the best one, its interval, and the chance that the verdict is by."""
    cell = found.at.cells[name]
    if not cell.best.law or law == cell.best.law:
        return [math.nan] * 4
    pair = pair_between(cell.pairs, law, cell.best.law)
    chance = pair.lost_chance if pair.by == "lost runs" else pair.chance
    return [*known_interval(*ratio_between(cell.pairs, law, cell.best.law)), chance]


def verdict_text(found: StudyView, name: str, law: str) -> str:
    """How a law stands to the best one of the cell."""
    best = found.at.cells[name].best
    if law == best.law:
        return "best"
    if found.at.cells[name].standings[law].lost.value > found.verdicts.rules.most_lost:
        return "out"
    by = pair_between(found.at.cells[name].pairs, law, best.law).by
    return {"error": "behind", "lost runs": "loses more"}.get(by, "tie")


def winner_text(found: StudyView, name: str) -> str:
    """Who wins a cell, in words."""
    best = found.at.cells[name].best
    if not best.law:
        return "No law stays stable"
    margin = ErrorRatio(best.margin, best.margin_low, best.margin_high)
    following = (
        f"; {best.next_family} has {interval_text(margin)} times its error" if best.next_family else ""
    )
    if best.state == "tie":
        return f"Tie between {', '.join(best.families)}; {best.law} is best{following}"
    return f"{best.law} wins{following}"
