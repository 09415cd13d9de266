"""The test for infinite numbers in a state, of which it reads no number that nobody else reads."""

from collections.abc import Sequence

from hydroservo.engine.state_text import record_of
from hydroservo.export.c.writer import Writer
from hydroservo.language.terms import BOOL, Function, Translator, Type


def infinite(translator: Translator, arguments: Sequence[Type]) -> Function:
    """``parts.infinite`` for records of one type."""
    (state,) = arguments
    record = record_of(state)
    parameters: list[tuple[str, Type]] = [("s", record)]
    name = translator.function_name("infinite")

    def text(writer: Writer) -> str:
        size, infinity = ("fabsf", "INFINITY") if writer.real == "float" else ("fabs", "(double)INFINITY")
        tests = [f"({size}(s->{place}) == {infinity})" for place in writer.leaves(record)]
        lines = [
            "/* True if any number is infinite. */",
            f"static bool {name}({writer.signature(parameters)}) {{",
            f"    return {' || '.join(tests)};",
            "}",
            "",
        ]
        return "\n".join(lines)

    return Function(name, parameters, returns=BOOL, written=text, whole=(record,))
