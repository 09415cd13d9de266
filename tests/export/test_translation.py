"""How Python becomes C: what C does, and what is refused with its line."""

from pathlib import Path

import numpy as np
import pytest

from hydroservo.engine.compiling import compiled_function
from hydroservo.engine.native import CompileError
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import CModule, Part
from hydroservo.language.scope import TranslationError
from tests.support.export.small_laws import FIRST, HEAD, NAMED, R, Y, assert_same, law, loop_of
from tests.support.needs import needs

TEXT = HEAD.replace(
    "import math\n", "import functools\nimport math\n", 1
)  # of a file whose law has no step yet


def translated(folder: Path, body: str, **changes: object) -> CModule:
    return exported_unit(law(folder, body, **changes), Part.CONTROLLER, **NAMED)


def refusal(folder: Path, body: str) -> str:
    with pytest.raises(TranslationError) as caught:
        translated(folder, body)
    message = str(caught.value)
    assert message.startswith(f"{folder}/law.py, line ")
    assert "\n" not in message
    return message


TRANSLATED = [
    "return LawState(self.gain * (r.value - y.velocity), s.u)",
    "e = r.value\nif e > 0.3:\n    u = self.gain * e\nelse:\n    u = -e\nreturn LawState(u, 0.0)",
    "if y.velocity > 0.5:\n    return LawState(1.0, 0.0)\nreturn LawState(2.0, s.u)",
    "u = 1.0 if 0.0 < y.velocity <= 0.25 and not r.rate > 0.0 else 2.0\nreturn LawState(u, 0.0)",
    "u = 1.0 if y.velocity > 5.0 or r.value > 0.5 else 2.0\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(self.turns):\n    u += (i + 1.0) * y.velocity\nreturn LawState(u, dt)",
    "u = 0.0\nfor _ in range(TURNS):\n    u = u + SLOPE\nreturn LawState(u, 0.0)",
    "u = 100.0\nwhile u > 1.0:\n    u = 0.5 * u\nreturn LawState(u, 0.0)",
    "a, b = y.velocity, r.value\na, b = b, a\nreturn LawState(a, b)",
    "a, b = self.pair(y.velocity, r.value)\nreturn LawState(a, b)",
    "s = LawState(s.u + 1.0, s.beside)\ns = LawState(s.u * 2.0, s.u)\nreturn s",
    "m = Measurement(y.velocity, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)\nreturn LawState(m.velocity, m.command)",
    "u: float = ops.where(self.reverse, -y.velocity, y.velocity)\nreturn LawState(u, 0.0)",
    "return ops.where(y.velocity > 0.0, LawState(1.0, 2.0), s)",
    "half = float(1 << self.turns) / 2\nreturn LawState(u=half, beside=y.command * y.command)",
    "return LawState(ops.power(math.e, y.velocity), ops.floor(-3.5 * r.value))",
    "switch = y.velocity\ndouble = r.value\nreturn LawState(switch - (double - dt), 1e-300 * switch)",
    "x = y.velocity\nx -= 1.0 - (2.0 - x)\nreturn LawState(x / 3.0 * r.rate / (x * 2.0), -(-x))",
    "x = y.velocity\nx = z = x + 1.0\nreturn LawState(x, z)",
    "μ = y.velocity\nμ = μ + 1.0\nλ = μ\nλ = λ * 2.0\nΔ = λ\nreturn LawState(μ, Δ)",
    "switch = y.velocity\nswitch_ = 2.0\nswitch = switch + 1.0\nswitch_ = switch_ + switch\n"
    "return LawState(switch, switch_)",
    "return LawState(slope * y.velocity, SLOPE)",
    "n = self.turns\nu = 0.0\nfor _ in range(n):\n    n = n - 1\n    u += 1.0\nreturn LawState(u, n * 1.0)",
    "u = 0.0\nfor i in range(9):\n    u += 1.0 * ((i - 5) // 2)\nreturn LawState(u, float(-7 // 2))",
    "return LawState(self.counted(2), self.counted(self.turns))",
    "n = 0\nfor k in range(100000):\n    n = n + k\nreturn LawState(1.0 * n, 0.0)",
    "n = 1\nfor _ in range(40):\n    n = n + n\nreturn LawState(1.0 * n, 0.0)",
    "u = 0.0\nfor _ in range(-(2**63)):\n    u = y.velocity\nreturn LawState(u, 0.0)",
    "u = ops.where(y.velocity > 0.1, 10**-3, 10**-2)\nreturn LawState(u, 1.0)",
    "k = 2\nif y.velocity > 0.1:\n    k = 1 << 40\nreturn LawState(1.0 * k, 1.0 * (k + True))",
    "p = LawState(y.velocity, 1.0)\nf = p.total\np = LawState(9.0, 9.0)\nreturn LawState(f(), p.total())",
    "a = 1.0\nb = 2.0\nc = 3.0\nc, (a, b) = a, (b, c)\nreturn LawState(a * 10.0 + b, c)",
    "o = Ops(2.0)\nreturn LawState(o.sqrt(), ops.sqrt(y.velocity))",
    "pair = Pair(1.5, y.velocity)\nreturn LawState(pair.left + pair.right, 0.0)",
    "a, _ = self.pair(1.0, 2.0)\nb, _ = self.pair(a, 3.0)\nreturn LawState(a, b)",
    "u = 0.0\nfor i in range(3):\n    for j in range(i):\n        u += i + 0.5 * j\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(3):\n    u += ops.sqrt(i) + ops.sqrt(y.velocity)\nreturn LawState(u, 0.0)",
    "NAN = y.velocity\nlaw_state = NAN + 1.0\nINFINITY = 2.0\nint32_t = 3.0\n"
    "return LawState(law_state + INFINITY, int32_t)",
    "state = y.velocity\nlaw_step = state\nself_ = 1.0\nreturn LawState(law_step + self_, state)",
    "law_pair = y.velocity\na, b = self.pair(law_pair, 1.0)\nreturn LawState(a, b)",
    "e: float\ne = y.velocity\nreturn LawState(e, -0.0 * e)",
    "return LawState(self._hidden(y.velocity), 0.0 * math.inf)",
    "u = 0.0\nif not (y.velocity > 0.5 or r.value < 0.0) and (True or y.velocity > 0.0):\n    u = 1.0\n"
    "return LawState(u, 0.0)",
    "x = 1.0\nwhile x < 100.0 and not x == 8.0:\n    x = x * 2.0\n    if x > 5.0:\n        x = x + 0.0\n"
    "return LawState(x, 0.0)",
    "double = Keyed(1.0, 2.0)\nreturn LawState(double.double, double.int)",
    # names that stand for one thing after the other
    "u = 1\nu = y.velocity\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(3):\n    i = i + 1\n    u += 1.0 * i\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(3):\n    for i in range(2):\n        u += 1.0\n    u += 1.0 * i\n"
    "return LawState(u, 0.0)",
    "i = 5\nif y.velocity > 0.0:\n    for i in range(3):\n        pass\nreturn LawState(1.0 * i, 0.0)",
    "i = 5.0\nu = i\nfor i in range(3):\n    u += i * 1.0\ni = u\nreturn LawState(i, u)",
    "u = 0.0\nfor i in range(3):\n    for i in range(i):\n        u += i + 0.5\nreturn LawState(u, 0.0)",
    "_ = 1.0\nif y.velocity > 0.0:\n    _ = 2.0\nreturn LawState(_, 0.0)",
    "_ = 1.0\nfor i in range(3):\n    _ = _ + i\nreturn LawState(_, 0.0)",
    "u = 0.0\nfor _ in range(3):\n    u += _ * 1.0\nreturn LawState(u, 0.0)",
    "a = 1.0\nfor _ in range(3):\n    b = a\n    a = b + 1.0\n    b = a\n    a = b + 1.0\n"
    "return LawState(a, 0.0)",
    # whole numbers of 64 bits
    "k = 0\nfor i in range(5):\n    k = i * 1000000000\nreturn LawState(1.0 * k, 0.0)",
    "k = 0\nfor i in range(46345):\n    k = i * i\nreturn LawState(1.0 * k, 0.0)",
    "k = 0\nfor i in range(50000):\n    k = k + i * i\nreturn LawState(1.0 * k, 0.0)",
    "n = 0\nx = 8.0\nwhile x > 1.0:\n    x = 0.5 * x\n    n = n + 1\nreturn LawState(1.0 * n, x)",
    # what a condition guards
    "u = 0.0\nif y.velocity > 9.0 and self.turned(-1.0).left > 0.0:\n    u = 1.0\nreturn LawState(u, 0.0)",
    "u = 0.0\nif y.velocity > -9.0 or self.turned(-1.0).left > 0.0:\n    u = 1.0\nreturn LawState(u, 0.0)",
    "u = self.turned(-1.0).left if y.velocity > 9.0 else self.turned(2.0).right\nreturn LawState(u, 0.0)",
    "p = self.turned(-1.0) if y.velocity > 9.0 else self.turned(2.0)\nreturn LawState(p.left, p.right)",
    "u = 0.0\nif not (y.velocity > 9.0 and (r.value > 0.0 or self.turned(-1.0).left > 0.0)):\n    u = 1.0\n"
    "return LawState(u, 0.0)",
    "k = 46341 * (-3 if y.velocity > 9.0 else 1000000000)\nreturn LawState(1.0 * k, 1.0 * (k - 7 * k))",
    "k = (5 if y.velocity > 9.0 else 2000000000) + (1 if r.value < 0.0 else 2000000000)\n"
    "return LawState(1.0 * k, 0.0)",
    "k = -(3 if y.velocity > 9.0 else 2147483647) - 2147483647\nreturn LawState(1.0 * k, 0.0)",
    # what a bare annotation leaves as it is
    "x = y.velocity\nx: float\nreturn LawState(x, 0.0)",
    "x = y.velocity\nfor i in range(3):\n    x = x + i\n    x: float\nreturn LawState(x, 0.0)",
    # what a compiler complains of where the same stands on both sides
    "k = 1\nfor i in range(3):\n    if k + i == i + k and not 2 * k - i > 2 * k - i:\n        k = k + i\n"
    "return LawState(1.0 * k, 0.0)",
    # what Python has besides
    "return LawState(max(y.velocity, 0.0), min(y.velocity, r.value, -0.0))",
    "u = 1.0\nreturn LawState(abs(-u) + abs(self.turns - 7), math.sqrt(abs(y.velocity)))",
    "u = 2.0\nif y.velocity:\n    u = 1.0\nif not self.turns - 2:\n    u = 3.0\nreturn LawState(u, 0.0)",
    "return LawState(y.velocity % 0.1, -y.velocity % self.gain)",
    "return LawState(y.velocity // 0.1, -y.velocity // self.gain)",
    "u = 0.0\nfor x in (1.0, y.velocity):\n    z = x * r.value\n    u += z\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i, x in enumerate(s):\n    u += i * x\nreturn LawState(u, 1.0 * len(s))",
    "return LawState(1.0 * (y.velocity > 0.0), 2.0 * (3 + (r.value < 0.0)))",
    "return LawState(*s)",
    "u = 0.0\nfor i in range(9, 1, -3):\n    u += i\nfor i in range(2, 4):\n    u *= i + 0.5\n"
    "return LawState(u, 0.0)",
    "u = 0.0\nwhile True:\n    u += 1.0\n    if u > 7.0:\n        break\n    if u > 3.0:\n        continue\n"
    "    u += 0.5\nreturn LawState(u, 0.0)",
    "u = 0.0\nfor i in range(9):\n    if i == 2:\n        continue\n    u += i\n    if u > 7.0:\n"
    "        break\nreturn LawState(u, 0.0)",
    "n = 0\nfor i in range(20):\n    n = n + (i - 9) % 4\nreturn LawState(1.0 * n, 0.0)",
    "p = (y.velocity, r.value, 3.0)\nreturn LawState(p[1] + p[-1], 1.0 * (r.value in p))",
    # signs that only copysign shows
    "return LawState(ops.copysign(1.0, -math.nan), ops.copysign(1.0, -0.0))",
]


@pytest.mark.parametrize("body", TRANSLATED)
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, id="as given"),
        pytest.param({"turns": 3, "reverse": True}, id="changed", marks=pytest.mark.slow),
    ],
)
def test_c_and_machine_code_do_what_python_does(
    body: str, changes: dict[str, object], tmp_path: Path
) -> None:
    needs("gcc")
    assert_same(law(tmp_path, body, **changes), tmp_path)


REFUSED = [
    # whole numbers that a float would stand for: their 0 has no minus, and their products are exact
    (
        "u = 1000000007 if r.value > 0.0 else 0.5\nreturn LawState(u * u * u, 0.0)",
        0,
        "a choice of a float",
        "1.0",
    ),
    ("return LawState(-ops.where(r.value > 0.0, 0.5, 0), 0.0)", 0, "a choice of a float", "1.0"),
    ("return LawState(-ops.maximum(-y.velocity, 0), 0.0)", 0, "for ops.maximum", "write 1.0 and not 1"),
    ("return LawState(ops.clip(y.velocity, -10, 10), 0.0)", 0, "for ops.clip", "write 1.0 and not 1"),
    (
        "p = Pair(1.0, 0)\nq = ops.where(r.value > 0.0, p, Pair(0.0, 1.0))\nreturn LawState(q.left, 0.0)",
        1,
        "a choice of two kinds of values",
        "one kind",
    ),
    ("if y.velocity > 9.0:\n    return LawState(0, 0.0)\nreturn s", 2, "different types", "one type"),
    ("return LawState(math.tanh(y.velocity), 0.0)", 0, "math.tanh", "use ops.tanh"),
    ("return LawState(math.exp(y.velocity), 0.0)", 0, "math.exp", "use ops.power(math.e, x)"),
    ("return LawState(y.velocity ** 1.5, 0.0)", 0, "a ** b", "use ops.power"),
    ("return LawState(ops.absolute([y.velocity]), 0.0)", 0, "[y.velocity]", "only ops"),
    ("if y.velocity > 0.0:\n    v = 1.0\nreturn LawState(v, 0.0)", 2, "v may have no value", "on every path"),
    ("print(y.velocity)\nreturn s", 0, "print", "only ops"),
    ("if y.velocity > 0.0:\n    return s", 0, "without a return", "every path"),
    ("if y.velocity > 0.0:\n    return y\nreturn s", 2, "different types", "one type"),
    ("try:\n    return s\nfinally:\n    pass", 0, "'try:'", "only ops"),
    ("return LawState(y.velocity, 0.0)._replace(u=1.0)", 0, "_replace of LawState", "plain method"),
    ("return LawState(s.v, 0.0)", 0, "neither a field nor a method 'v'", "only ops"),
    ("return LawState(ops.absolute(NAMES), 0.0)", 0, "NAMES is a list", "floats and blocks"),
    ("return LawState(1.0)", 0, "given no beside", "every field"),
    ("return LawState(ops.where(y.velocity, 1.0, 0.0), 0.0)", 0, "not a truth value", "compare it"),
    ("return LawState(self.step(s, y, r, dt).u, 0.0)", None, "calls itself", ""),
    ("return (lambda: s)()", 0, "lambda", "only ops"),
    ("f = [y]\nreturn s", 0, "'[y]'", "only ops"),
    ("return LawState(ops.power(y.velocity), 0.0)", 0, "missing a required argument", "mend the call"),
    ("a, b = y\nreturn s", 0, "7 values for 2 names", "give each a name"),
    ("for x in (1.0, 2.0):\n    break\nreturn s", 0, "runs to its end", "count with range"),
    ("for x in y.velocity:\n    pass\nreturn s", 0, "only range(...) and tuples", "count with range"),
    ("return LawState(float(int(y.velocity)), 0.0)", 0, "int of a float", "ops.floor or ops.nearest"),
    ("return LawState(round(y.velocity), 0.0)", 0, "round", "use ops.nearest"),
    ("return LawState(1.0 * (5 // (self.turns * len(s) - i)), 0.0)", 0, "i is not defined", ""),
    ("raise ValueError", 0, "'raise ValueError'", "return math.nan"),
    ("return LawState(y.velocity ** 2, 0.0)", 0, "a ** b", "write x * x"),
    ("return LawState(1.0 * (self.turns or 3), 0.0)", 0, "'self.turns' is not a truth value", "compare it"),
    ("return LawState(1.0 * (1 // (self.turns - 2)), 0.0)", 0, "by zero", ""),
    ("return LawState(y.velocity * 10**400, 0.0)", 0, "more than 64 bits", ""),
    ("return LawState(y.velocity * (1 << 4000), 0.0)", 0, "more than 64 bits", ""),
    ("for _ in range(2**63):\n    break\nreturn LawState(0.0, 0.0)", 0, "beyond 64 bits", "floats"),
    ("for _ in range(0, 2**63 - 1, 3):\n    break\nreturn LawState(0.0, 0.0)", 0, "beyond 64 bits", "floats"),
    ("for _ in range(0, -(2**63), -2):\n    break\nreturn LawState(0.0, 0.0)", 0, "beyond 64 bits", "floats"),
    ("n = 1\nfor _ in range(60):\n    n = n * 3\nreturn LawState(1.0 * n, 0.0)", 2, "may outgrow", "floats"),
    (
        "i = 5.0\nif r.value > 0.0:\n    for i in range(3):\n        pass\nreturn LawState(i, 0.0)",
        2,
        "i changes its type",
        "1.0",
    ),
    (
        "for i in range(3):\n    pass\nreturn LawState(1.0 * i, 0.0)",
        2,
        "i may have no value yet",
        "every path",
    ),
    (
        "k = 0\nfor i in range(1 << 40):\n    k = i * i\nreturn LawState(1.0 * (k - k), 0.0)",
        2,
        "may outgrow 64 bits",
        "floats",
    ),
    (
        "k = 1\nfor _ in range(70):\n    k = k + k\nreturn LawState(1.0 * (k - k), 0.0)",
        2,
        "may outgrow",
        "floats",
    ),
    (
        "a, b = 0, 1\nfor _ in range(99):\n    a, b = b, a + b\nreturn LawState(1.0 * a, 0.0)",
        2,
        "may outgrow",
        "floats",
    ),
    (
        "k = 0\nfor i in range(1 << 30):\n    k = k + i\nreturn LawState(1.0 * k, 0.0)",
        3,
        "may outgrow -9007199254740992",
        "floats",
    ),
    ("return LawState(y.velocity + (2**53 + 1), 0.0)", 0, "no float holds", "float"),
    ("n = 1\nif y.velocity > 0.0:\n    n = 1 << 60\nreturn LawState(1.0 * n, 0.0)", 2, "2^53", "float"),
    (
        "return LawState(self.half, 0.0)",
        0,
        "half of Law is not a method of its own (property)",
        "plain method",
    ),
    ("return LawState(float('nan'), 0.0)", 0, "'nan'", "use math.nan"),
    (
        "return LawState(outside(y.velocity), 0.0)",
        0,
        "outside(y.velocity) is a function of a module",
        "method of the block",
    ),
    ("return LawState(self.many(1.0, 2.0), 0.0)", 0, "many takes arguments with *", "name each"),
    ("return LawState(*[0.0] * s.u)", 0, "*[0.0] * s.u", "write *[0.0] * n with a whole number n"),
    ("return LawState(s[2], 0.0)", 0, "the index 2 is out of the record's 2", ""),
    ("for i in range(self.turns):\n    u = s[i]\nreturn LawState(u, 0.0)", 1, "by a known number alone", ""),
    (
        "return LawState(np.interp(s.u, [0.0], [1.0]), 0.0)",
        0,
        "np.interp",
        "hydroservo.core.curve.Curve",
    ),
    ("return LawState(np.zeros(2)[0], 0.0)", 0, "np.zeros", "hydroservo.core.vectors.vector"),
    (
        "return LawState(np.random.normal(), 0.0)",
        0,
        "np.random.normal",
        "use ops.normal(seed, stream, index)",
    ),
    ("return (y.velocity, 0.0)", None, "Law.step: it must return the record that init returns", ""),
    ("return LawState(y.velocity, 1)._asdict()", 0, "_asdict", "plain method"),
    ("return Twice(1.0, 2.0)", 0, "have one name in C", "rename one"),
    ("u = y.velocity if r else 0.0\nreturn LawState(u, 0.0)", 0, "'r' is not a truth value", "compare it"),
    ("x = y.velocity\ndel x\nreturn s", 1, "'del x'", "only ops"),
    ("assert y.velocity\nreturn s", 0, "'assert y.velocity'", "return math.nan"),
    ("if (v := y.velocity) > 0.0:\n    return s\nreturn s", 0, "(v := y.velocity)", "only ops"),
]


@pytest.mark.parametrize(("body", "line", "problem", "way_out"), REFUSED, ids=[one[0] for one in REFUSED])
def test_what_is_not_in_the_language_is_refused_in_the_same_words(
    body: str, line: int | None, problem: str, way_out: str, tmp_path: Path
) -> None:
    message = refusal(tmp_path, body)
    assert problem in message
    assert way_out in message
    if line is not None:
        controller = law(tmp_path, body).controller
        with pytest.raises(CompileError) as error:
            compiled_function(type(controller).step)(controller, controller.init(), Y, R, 1e-3)
        assert message.endswith(f": {error.value}")
    if line is not None and "without a return" not in problem:
        assert f"line {FIRST + line}, Law.step" in message


@pytest.mark.parametrize("method", ["init", "step"])
@pytest.mark.parametrize("decorator", ["staticmethod", "classmethod", "property", "functools.cache"])
def test_a_law_whose_own_methods_are_no_plain_ones_is_refused(
    method: str, decorator: str, tmp_path: Path
) -> None:
    text = TEXT.replace(f"    def {method}(", f"    @{decorator}\n    def {method}(") + "        return s\n"
    message = refused_text(text, tmp_path)
    assert f"law.py: {method} of Law is not a method of its own (" in message
    assert "plain method of the class" in message


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("step(self, s, y, r, dt)", "step(self, s, y, r)", "Law.step: it takes 4 arguments, and is given 5"),
        ("step(self, s, y, r, dt)", "step(self, s, y, r, dt, x=1.0)", "it takes 6 arguments, and is given 5"),
        ("init(self)", "init(self, x=1.0)", "Law.init: it takes 2 arguments, and is given 1"),
        ("def step(", "def steps(", "law.py: Law has no method step"),
    ],
)
def test_a_law_whose_methods_take_other_arguments_is_refused(
    old: str, new: str, problem: str, tmp_path: Path
) -> None:
    assert problem in refused_text(TEXT.replace(old, new) + "        return s\n", tmp_path)


def test_a_method_may_take_arguments_by_position_alone(tmp_path: Path) -> None:
    needs("gcc")
    text = TEXT.replace("def early(self, a, b)", "def early(self, a, /, b)").replace("r, dt)", "r, dt, /)")
    text += "        return LawState(self.early(y.velocity, b=2.0), dt)\n"
    assert text.count("/") > TEXT.count("/") + 1
    assert_same(loop_of(tmp_path, text), tmp_path)


def test_a_law_that_inherits_its_methods_is_refused(tmp_path: Path) -> None:
    text = TEXT.replace("class Law(", "class Base(") + "        return s\n\n\nclass Law(Base):\n    pass\n"
    assert "init of Law is not a method of its own (inherited)" in refused_text(text, tmp_path)


def refused_text(text: str, folder: Path) -> str:
    with pytest.raises(TranslationError) as caught:
        exported_unit(loop_of(folder, text), Part.CONTROLLER, **NAMED)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ("1", "a whole number for Curve.value, which takes floats; write 1.0 and not 1"),
        ("s", "a number is needed here"),
        ("y.velocity > 0.0", "a whole number for Curve.value, which takes floats"),
    ],
)
def test_what_is_no_float_for_a_block_that_takes_floats_is_refused_with_the_laws_line(
    given: str, problem: str, tmp_path: Path
) -> None:
    text = TEXT.replace(
        "from hydroservo import ops\n",
        "from hydroservo import ops\nfrom hydroservo.core.time_series import TimeSeries\n",
    )
    text = text.replace("\n    def init", "    series: TimeSeries = TimeSeries()\n\n    def init", 1)
    text += f"        return LawState(self.series.value({given}), 0.0)\n"
    message = refused_text(text, tmp_path)
    assert f"line {text.count(chr(10))}, Law.step: {problem}" in message


@pytest.mark.parametrize("read", ["self.table[1]", "y.velocity"])
def test_an_array_is_in_the_c_only_if_something_reads_it(read: str, tmp_path: Path) -> None:
    needs("gcc")
    field = "    table: np.ndarray = np.array([1.5, -0.0, 4.25])\n\n    def init"
    text = TEXT.replace("\n    def init", field, 1) + f"        return LawState({read}, 0.0)\n"
    loop = loop_of(tmp_path, text)
    assert ("table" in exported_unit(loop, Part.CONTROLLER, **NAMED).source) is ("table" in read)
    assert_same(loop, tmp_path)


def test_a_number_of_numpy_is_exported_as_the_float_that_runs_take_it_for(tmp_path: Path) -> None:
    body = "return LawState(self.gain * y.velocity, 1.0 * self.turns)"
    units = [
        translated(tmp_path, body, gain=gain, turns=turns)
        for gain, turns in ((np.float32(0.1), np.int64(3)), (float(np.float32(0.1)), 3))
    ]
    assert units[0] == units[1]
