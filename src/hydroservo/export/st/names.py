"""Names in Structured Text, which has no case, and literals that all of its compilers take."""

import math
import re

from hydroservo.export.single import single_literal
from hydroservo.language.names import free_name, spelt

KEYWORDS = (
    "abstract action and and_then array at begin by case class configuration constant continue do else "
    "elsif end exit extends external f_edge final finally for from function function_block get global "
    "goto if implements in inherited initial_step int interface internal interval label local map "
    "method mod namespace nil none not null of on or or_else order overlap override pointer priority "
    "private program property protected public r_edge read_only read_write ref ref_to reference region "
    "repeat resource result retain return set single step string struct structure super system task "
    "then this to transition true false try catch type until using var var_access var_config "
    "var_external var_global var_in_out var_inst var_input var_output var_stat var_temp version while "
    "with wstring xor"
)
TYPES = (
    "any any_num any_real any_int any_bit any_date bool byte word dword lword sint usint dint udint "
    "lint ulint uint real lreal time ltime date ldate date_and_time time_of_day dt ldt tod ltod d t td "
    "lt ld char wchar bit"
)
FUNCTIONS = (
    "en eno abs acos add adr and andn asin atan atan2 bitadr byte_to cal calc calcn ceil concat cos ctd ctu "
    "ctud del delete delta deriv derivative div divtime end_if eq exp expt f_trig find floor frac ge gt "
    "hysteresis indexof ini insert integral is_valid jmp jmpc jmpcn ld ldn le left len limit ln log "
    "lower_bound lt max mid min move mul muldiv multime mux n n_int ne neg now p p0 p1 pd pid r r1 "
    "r_trig ramp random replace ret retc retcn right rol ror round rs rtc s s1 sel sema shl shr sign "
    "sin sizeof sl sqrt sr st stn sub tan tof ton totalizer tp trunc truncate upper_bound"
)
TYPE_NAMES = frozenset(TYPES.split(" "))
RESERVED = frozenset(f"{KEYWORDS} {TYPES} {FUNCTIONS}".split(" "))
SUFFIX = "_value"  # a reserved word


def is_reserved(name: str) -> bool:
    """True for what the language, its standard functions or a vendor's dialect has taken."""
    word = name.casefold()
    converts = set(word.split("_to_")) <= TYPE_NAMES
    return word in RESERVED or word.startswith(("end_", "to_", "var_")) or converts


def unused_name(wish: str, taken: set[str]) -> str:
    """The name nearest to a wish that is allowed and not taken; it is taken from now on."""
    letters = "".join(letter if letter.isascii() else spelt(letter) for letter in wish)
    plain = re.sub("_+", "_", letters).strip("_") or "own"
    plain = f"own_{plain}" if plain[0].isdigit() else plain
    plain = f"{plain}{SUFFIX}" if is_reserved(plain) else plain
    name = free_name(plain, lambda one: one.casefold() in taken)
    taken.add(name.casefold())
    return name


LEAST, MOST = 2.0**-126, 2.0**127  # of a literal's size, also where it stands for an LREAL
BEYOND = 2000  # an exponent of two that is none of a finite number


def literal_of(value: float, real: str) -> str:
    """The literal of a number; empty where it has none of a size that all compilers take."""
    size = abs(value)
    if not (size == 0.0 or LEAST <= size < MOST):
        return ""
    return real_literal(single_literal(value) if real == "REAL" else repr(float(value)))


def parts_of(value: float, real: str) -> tuple[str, str]:
    """The literals of a mantissa and an exponent of two that give a number."""
    if not math.isfinite(value):
        return real_literal(repr(math.copysign(1.0, value))), f"{BEYOND}.0"
    mantissa, exponent = math.frexp(value)
    return literal_of(mantissa, real), f"{exponent}.0"


def real_literal(text: str) -> str:
    """Python's text of a number, as Structured Text asks for it."""
    digits, _, size = text.partition("e")
    return f"{digits if '.' in digits else f'{digits}.0'}{f'E{int(size)}' if size else ''}"
