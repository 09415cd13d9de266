"""Names in C."""

import keyword
import re
import unicodedata
from collections.abc import Callable

KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int "
    "long register restrict return short signed sizeof static struct switch typedef union unsigned void "
    "volatile while bool true false asm main errno"
)
CPLUSPLUS = (
    "alignas alignof and_eq bitand bitor catch char16_t char32_t class compl concept const_cast constexpr "
    "decltype delete dynamic_cast explicit export friend mutable namespace new noexcept not_eq nullptr "
    "operator or_eq private protected public reinterpret_cast requires static_assert static_cast template "
    "this thread_local throw try typeid typename using virtual wchar_t xor xor_eq"
)
MATHS = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs "
    "fdim floor fma fmax fmin fmod frexp hypot ilogb j0 j1 jn ldexp lgamma llrint llround log log10 "
    "log1p log2 logb lrint lround modf nan nearbyint nextafter pow remainder remquo rint round scalbn "
    "sin sinh sqrt tan tanh tgamma trunc y0 y1 yn gamma isnan isinf isfinite signbit "
    "fpclassify isnormal isgreater isgreaterequal isless islessequal islessgreater "
    "isunordered offsetof math_errhandling signgam"
)
HEADERS = (
    "NAN INFINITY HUGE_VAL HUGE_VALF FLT_EVAL_METHOD NULL int8_t int16_t int32_t int64_t uint8_t uint16_t "
    "uint32_t uint64_t intptr_t uintptr_t intmax_t uintmax_t float_t double_t linux unix"
)
RESERVED = frozenset(f"{KEYWORDS} {CPLUSPLUS} {MATHS} {HEADERS}".split(" "))
FAMILIES = re.compile(  # macros of the headers that the C includes, and of compilers
    r"(DBL|FLT|LDBL|DECIMAL|DEC32|DEC64|DEC128|FP|HUGE|M|MATH|U?INT\d*|INTPTR|UINTPTR|INTMAX|UINTMAX|PTRDIFF|"
    r"SIG_ATOMIC|SIZE|WCHAR|WINT|SEEK|TMP|FOPEN|FILENAME|L|SNAN|SNANF|SNANL|SCHAR|CHAR|SHRT|LONG|ULONG)_\w+|"
    r"BUFSIZ|EOF|EXIT_\w+|DOMAIN|SING|OVERFLOW|UNDERFLOW|PLOSS|TLOSS|X_TLOSS|MAXFLOAT|HUGE|i386|near|far"
)


def snake(name: str) -> str:
    """A class's name as C writes those of types: TSMObserverState is tsm_observer_state."""
    parted = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", name)
    return identifier(re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", parted).lower())


def identifier(name: str) -> str:
    """A name that C allows: an underscore behind one that it has taken, and Greek letters written out."""
    plain = "".join(letter if letter.isascii() else spelt(letter) for letter in name)
    if re.match("_[A-Z_]", plain):  # all of these are the compiler's
        plain = f"own_{plain.strip('_')}"
    return f"{plain}_" if taken_by_c(plain) else plain


def place_in_c(path: str) -> str:
    """The place in C of the number at a dotted path in Python."""
    return ".".join(map(identifier, path.split(".")))


def taken_by_c(name: str) -> bool:
    """True for a word of C or C++, or what their headers define."""
    return name in RESERVED or FAMILIES.fullmatch(name) is not None


def spelt(letter: str) -> str:
    """A letter outside of ASCII: mu, Delta, or its number."""
    words = unicodedata.name(letter, "").split(" ")
    if words[0] == "GREEK" and len(words) == 4:
        return words[3].lower() if words[1] == "SMALL" else words[3].capitalize()
    return f"u{ord(letter):x}"


def is_identifier(name: str) -> bool:
    """True for a name that C allows and has not taken."""
    return name.isascii() and name.isidentifier() and not keyword.iskeyword(name) and not taken_by_c(name)


def free_name(name: str, taken: Callable[[str], bool]) -> str:
    """A name with the first number behind it under which it is free."""
    found, number = name, 2
    while taken(found):
        found, number = f"{name}_{number}", number + 1
    return found
