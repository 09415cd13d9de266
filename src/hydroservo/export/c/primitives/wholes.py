"""Divisions of whole numbers, rounded as Python does."""

from hydroservo.language.terms import INT, Function, Type

QUOTIENT_TEXT = """\
/* The largest whole number not above a/b, for b > 0. */
static int64_t ops_quotient(int64_t a, int64_t b) {
    return ((a % b) < 0) ? ((a / b) - 1) : (a / b);
}
"""
MODULO_TEXT = """\
/* a - b floor(a/b), for b > 0. */
static int64_t ops_modulo(int64_t a, int64_t b) {
    return ((a % b) < 0) ? ((a % b) + b) : (a % b);
}
"""
PAIR: list[tuple[str, Type]] = [("a", INT), ("b", INT)]
QUOTIENT = Function("ops_quotient", PAIR, returns=INT, written=lambda _: QUOTIENT_TEXT)
MODULO = Function("ops_modulo", PAIR, returns=INT, written=lambda _: MODULO_TEXT)
