"""Exports written by hand, as the translation writes them."""

from hydroservo.export.unit import Argument, CModule, Part, Signal


def by_hand(
    prefix: str,
    title: str,
    period: float,
    texts: tuple[str, str],
    parameters: tuple[Signal, ...],
    arguments: tuple[Argument, ...],
    states: tuple[Signal, ...],
    *,
    part: Part,
) -> CModule:
    """An export in double precision, from the texts of its header and source, and what is in them."""
    header, source = texts
    return CModule(
        part=part,
        prefix=prefix,
        title=title,
        scenario='type = "<Loop>"\n',
        hash=f"{prefix}-hash",
        version="0.0.0",
        period=period,
        real="double",
        inlined=False,
        header=header,
        source=source,
        parameters=parameters,
        arguments=arguments,
        states=states,
    )
