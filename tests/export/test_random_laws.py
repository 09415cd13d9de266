"""Random laws: what C does is what Python does, bit for bit."""

import math
from textwrap import indent

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from small_laws import R, Y, assert_same, law

from needs import needs

NUMBERS = st.sampled_from(["a", "b", "c", "y.velocity", "r.value", "self.gain", "SLOPE", "0.5", "-3.0", "dt"])
WHOLES = st.sampled_from(["k", "n", "2", "-3", "self.turns", "TURNS"])


def sums(leaves: st.SearchStrategy[str], forms: list[str]) -> st.SearchStrategy[str]:
    """Expressions made of these forms."""
    return st.recursive(
        leaves,
        lambda inner: st.builds(lambda form, x, z: form.format(x, z), st.sampled_from(forms), inner, inner),
    )


REALS = sums(
    NUMBERS,
    [
        "({} + {})",
        "({} - {})",
        "{} * {}",
        "-({} - {})",
        "ops.maximum({}, {})",
        "ops.where({} > 1 + {}, a, -b)",
    ],
)
INTEGERS = sums(WHOLES, ["({} + {})", "({} - {})", "({} + {}) // 3"])
CONDITIONS = st.builds(
    lambda form, x, z, i: form.format(x, z, i),
    st.sampled_from(["{} > 0.25 + {}", "not {} <= 0.25 + {}", "{} < 1 + {} or {} > 1", "{} < 1 + {} < 2.0"]),
    REALS,
    REALS,
    INTEGERS,
)
SIMPLE = st.one_of(
    st.builds("{} = {}".format, st.sampled_from("abc"), REALS),
    st.builds("{} += {}".format, st.sampled_from("abc"), REALS),
    st.builds("{} = {}".format, st.sampled_from("kn"), INTEGERS),
    st.builds("a, b = {}, {}".format, REALS, REALS),
    st.builds("a = c = {}".format, REALS),
    st.builds("b, c = self.pair({}, {})".format, REALS, REALS),
    st.builds("a = {} * k".format, REALS),
)


def blocks(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """A statement around others."""
    body = st.lists(inner, min_size=1, max_size=3).map(lambda lines: indent("\n".join(lines), "    "))
    return st.one_of(
        st.builds("if {}:\n{}\nelse:\n{}".format, CONDITIONS, body, body),
        st.builds("if {}:\n{}".format, CONDITIONS, body),
        st.builds("for _ in range({}):\n{}".format, st.sampled_from(["3", "self.turns", "n - n + 2"]), body),
    )


LAWS = st.lists(st.recursive(SIMPLE, blocks, max_leaves=6), min_size=2, max_size=8).map(
    lambda lines: "\n".join(
        [
            "a, b, c = y.velocity, r.value, 1.0",
            "k, n = 1, 2",
            *lines,
            "return LawState(a * b - c, 1.0 * (k - n))",
        ]
    )
)


@pytest.mark.slow
@settings(max_examples=40)
@given(body=LAWS)
def test_c_does_what_python_does(body: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    needs("gcc")
    folder = tmp_path_factory.mktemp("law")
    loop = law(folder, body)
    first = loop.controller.step(loop.controller.init(), Y, R, 1e-3)
    assume(all(math.isfinite(x) and abs(x) < 1e15 for x in first))
    assert_same(loop, folder)
