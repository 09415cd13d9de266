"""How exported C is laid out."""

import re

import pytest

from hydroservo.export.layout import INDENT, lay_out
from hydroservo.export.texts import WIDTH
from tests.support.export.cases import Case, each_case, unit_of

LONG = "a_long_name_of_a_number_of_the_state"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "void f(void) {\nif (a) {\nb = c;\n} else {\n*b = -c;\n}\n}\n",
            "void f(void) {\n    if (a) {\n        b = c;\n    } else {\n        *b = -c;\n    }\n}\n",
        ),
        (
            "/*\n * a:\n *     b\n */\n#define A 1\n\n*state = b;",
            "/*\n * a:\n *     b\n */\n#define A 1\n\n*state = b;",
        ),
        (
            "{\nint a; /* [V] */\ndouble b; /* [m] */\npart c;\nint d; /* [s] */\n};",
            "{\n    int a;    /* [V] */\n    double b; /* [m] */\n    part c;\n    int d; /* [s] */\n};",
        ),
        ("{\nint LONG = f(LONG) + LONG;", "{\n    int LONG =\n        f(LONG) + LONG;"),
        ("x = -LONG * LONG * f(LONG + b);", "x = -LONG\n    * LONG\n    * f(LONG + b);"),
        (
            "T f(const T *LONG, const T *LONG, int LONG) {\nreturn 0;\n}",
            "T f(\n    const T *LONG,\n    const T *LONG,\n    int LONG\n) {\n    return 0;\n}",
        ),
        (
            "return (T){.a = LONG, .b = g(a, LONG, LONG)};",
            "return (T){\n    .a = LONG,\n    .b = g(a, LONG, LONG)\n};",
        ),
        (
            "x = ((LONG + LONG) - LONG - LONG) / b;",
            "x =\n    (\n        (LONG + LONG)\n        - LONG\n        - LONG\n    )\n    / b;",
        ),
    ],
)
def test_lines_are_indented_and_parted_where_they_are_long(text: str, expected: str) -> None:
    text, expected = (one.replace("LONG", LONG) for one in (text, expected))
    assert lay_out(text) == expected


@each_case
def test_no_line_is_long_and_none_hangs(case: Case) -> None:
    for text in (unit_of(case).header, unit_of(case).source):
        lines = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).splitlines()
        assert max(map(len, lines)) <= WIDTH
        assert {(len(line) - len(line.lstrip())) % len(INDENT) for line in lines} == {0}
        depth = 0
        for line in lines:
            depth += len(re.findall(r"[({[]", line)) - len(re.findall(r"[)}\]]", line))
            assert depth >= 0
        assert depth == 0
