"""Exported C with numbers that count what is done with them: its text as C++, with a class for double."""

import math
from pathlib import Path

from hydroservo.export.unit import CModule, Operations
from tools.targets.compilers import output
from tools.targets.sources import Rows, width

COMPILER = "clang++"
OPTIONS = ("-std=c++20", "-O1", "-ffp-contract=off", "-Wno-everything")
NUMBER = """\
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

static long additions, multiplications, divisions, roots, comparisons;

struct Number {
    double value;
    Number() = default;
    constexpr Number(double given) : value(given) {}
};

#define BINARY(sign, count) \\
    static Number operator sign(Number a, Number b) { count++; return a.value sign b.value; }
#define COMPARISON(sign) \\
    static bool operator sign(Number a, Number b) { comparisons++; return a.value sign b.value; }
BINARY(+, additions)
BINARY(-, additions)
BINARY(*, multiplications)
BINARY(/, divisions)
COMPARISON(<)
COMPARISON(<=)
COMPARISON(>)
COMPARISON(>=)
COMPARISON(==)
COMPARISON(!=)
static Number operator-(Number a) { return -a.value; }
static Number sqrt(Number a) { roots++; return sqrt(a.value); }
static Number fabs(Number a) { return fabs(a.value); }
static Number copysign(Number a, Number b) { return copysign(a.value, b.value); }
static bool isnan(Number a) { comparisons++; return isnan(a.value); }
static bool isfinite(Number a) { comparisons++; return isfinite(a.value); }
"""
MAIN = """\
static const double rows[][{width}] = {{{rows}}};

int main() {{
    {p}_state state;
    {p}_init(&state, &{p}_defaults);
    for (const auto &row : rows) {{
        {p}_measurement measurement;
        {p}_demand demand;
        {given}
        additions = multiplications = divisions = roots = comparisons = 0;
        {p}_step(&state, &{p}_defaults, &measurement, &demand);
        printf("%ld %ld %ld %ld %ld\\n", additions, multiplications, divisions, roots, comparisons);
    }}
    return 0;
}}
"""


def operations_done(unit: CModule, rows: Rows, folder: Path) -> list[Operations]:
    """What each step of a controller does, without its calls of functions.

    Raises:
        ToolError: it does not compile, or does not run to its end.
    """
    places = [f"{one.name}.{signal.place}" for one in unit.arguments for signal in one.signals]
    main = MAIN.format(
        p=unit.prefix,
        width=width(unit),
        rows=", ".join(f"{{{', '.join(map(literal, row))}}}" for row in rows.tolist()),
        given="\n        ".join(f"{place} = row[{i}];" for i, place in enumerate(places)),
    )
    (folder / f"{unit.prefix}.h").write_text(unit.header, "utf-8")
    texts = [NUMBER, "#define double Number", unit.source, "#undef double", main]
    source, program = folder / "counting.cpp", folder / "counting"
    source.write_text("\n".join(texts), "utf-8")
    output([COMPILER, *OPTIONS, source, "-o", program])
    lines = output([program]).splitlines()
    return [Operations(*map(int, line.split())) for line in lines]


def literal(value: float) -> str:
    """A number in C++, to the last bit."""
    if math.isfinite(value):
        return value.hex()
    return "NAN" if math.isnan(value) else f"{math.copysign(1.0, value):g} * INFINITY"
