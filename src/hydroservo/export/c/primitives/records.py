"""Arithmetic on whole states, as in ``states``, number by number."""

from collections.abc import Sequence

from hydroservo import states
from hydroservo.export.c.primitives.kinds import has_numbers, joined, record_of
from hydroservo.export.c.writer import Writer
from hydroservo.export.names import identifier
from hydroservo.export.translate.terms import BOOL, REAL, Function, Record, Translator, Type

__all__ = ["axpy", "infinite", "misses", "scaled"]

Parameters = list[tuple[str, Type]]


def axpy(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.axpy`` for records of one type."""
    record = record_of(arguments[0])
    parameters: Parameters = [("x", record), ("h", REAL), ("k", record)]
    name = translator.function_name(f"axpy_{record.name}")
    return each_number(name, "x + h k", record, parameters, "x->{0} + (h * k->{0})")


def scaled(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.scaled`` for records of one type."""
    record = record_of(arguments[1])
    parameters: Parameters = [("h", REAL), ("k", record)]
    name = translator.function_name(f"scaled_{record.name}")
    return each_number(name, "h k", record, parameters, "h * k->{0}")


def each_number(name: str, what: str, record: Record, parameters: Parameters, number: str) -> Function:
    """A function that makes a record, each number by the same expression of others."""

    def text(writer: Writer) -> str:
        kind = writer.type(record)
        lines = [
            f"/* {what}, number by number. */",
            f"static {kind} {name}({writer.signature(parameters)}) {{",
            f"    {kind} result;",
            *(f"    result.{place} = {number.format(place)};" for place in writer.leaves(record)),
            "    return result;",
            "}",
            "",
        ]
        return "\n".join(lines)

    return Function(name, parameters, returns=record, written=text)


def misses(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``states.misses`` for records of one type."""
    record = record_of(arguments[0])
    miss = translator.function(states.miss, [REAL] * 5)
    called = {
        field: translator.function(states.misses, [kind] * 4 + [REAL]) if isinstance(kind, Record) else miss
        for field, kind in record.fields.items()
        if has_numbers(kind)
    }
    name = translator.function_name(f"misses_{record.name}")
    names = ("error", "x", "y", "rate")
    parameters: Parameters = [*((one, record) for one in names), ("dt", REAL)]

    def text(writer: Writer) -> str:
        lines = [
            "/* The sum of the squares of a step's relative errors. */",
            f"static double {name}({writer.signature(parameters)}) {{",
            "    double total = 0.0;",
        ]
        for field, callee in called.items():
            mark = "" if callee is miss else "&"
            given = ", ".join(f"{mark}{one}->{identifier(field)}" for one in names)
            lines.append(f"    total = total + {callee.name}({given}, dt);")
        return "\n".join([*lines, "    return total;", "}", ""])

    return Function(name, parameters, written=text, calls=(miss, *called.values()), whole=(record,))


def infinite(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``parts.infinite`` for records of one type."""
    (state,) = arguments
    record = record_of(state)
    parameters: Parameters = [("s", record)]
    name = translator.function_name(f"infinite_{record.name}")

    def text(writer: Writer) -> str:
        checks = [f"(isinf(s->{place}) != 0)" for place in writer.leaves(record)]
        lines = [
            "/* True if any number is infinite. */",
            f"static bool {name}({writer.signature(parameters)}) {{",
            f"    return {joined(checks, 8, ' ||')};",
            "}",
            "",
        ]
        return "\n".join(lines)

    return Function(name, parameters, returns=BOOL, written=text, whole=(record,))
