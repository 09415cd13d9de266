"""Names in C."""

import keyword
import re
import unicodedata
from collections.abc import Callable

__all__ = ["identifier", "is_identifier", "numbered", "snake"]

KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int "
    "long register restrict return short signed sizeof static struct switch typedef union unsigned void "
    "volatile while bool true false asm main errno"
)
MATHS = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs "
    "fdim floor fma fmax fmin fmod frexp hypot ilogb j0 j1 jn ldexp lgamma llrint llround log log10 "
    "log1p log2 logb lrint lround modf nan nearbyint nextafter pow remainder remquo rint round scalbn "
    "sin sinh sqrt tan tanh tgamma trunc y0 y1 yn gamma isnan isinf isfinite"
)
HEADERS = (
    "NAN INFINITY HUGE_VAL HUGE_VALF FLT_EVAL_METHOD NULL int8_t int16_t int32_t int64_t uint8_t uint16_t "
    "uint32_t uint64_t intptr_t uintptr_t intmax_t uintmax_t float_t double_t linux unix"
)
RESERVED = frozenset(f"{KEYWORDS} {MATHS} {HEADERS}".split(" "))


def snake(name: str) -> str:
    """A class's name as C writes those of types: TSMObserverState is tsm_observer_state."""
    parted = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", name)
    return identifier(re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", parted).lower())


def identifier(name: str) -> str:
    """A name that C allows: an underscore behind one that it has taken, and Greek letters written out."""
    plain = "".join(letter if letter.isascii() else spelt(letter) for letter in name)
    return f"{plain}_" if plain in RESERVED else plain


def spelt(letter: str) -> str:
    """A letter outside of ASCII: mu, Delta, or its number."""
    words = unicodedata.name(letter, "").split(" ")
    if words[0] == "GREEK" and len(words) == 4:
        return words[3].lower() if words[1] == "SMALL" else words[3].capitalize()
    return f"u{ord(letter):x}"


def is_identifier(name: str) -> bool:
    """True for a name that C allows and has not taken."""
    return name.isascii() and name.isidentifier() and not keyword.iskeyword(name) and name not in RESERVED


def numbered(name: str, taken: Callable[[str], bool]) -> str:
    """A name with the first number behind it under which it is free."""
    found, number = name, 2
    while taken(found):
        found, number = f"{name}_{number}", number + 1
    return found
