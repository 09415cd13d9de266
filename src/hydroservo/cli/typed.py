"""The command as it was typed."""

import shlex

import typer

NO_MATTER = (  # options that change nothing of what is found
    "out",
    "threads",
    "workers",
    "scheduler",
    "json",
    "verbose",
    "decimal_comma",
    "figure_format",
    "figure_size",
)


def command_typed(context: typer.Context) -> list[str]:
    """The running command without what changes nothing of what it finds.

    Args:
        context: of the command.

    Returns:
        Its start, then each option, quoted for a shell.
    """
    parts = [["hydroservo", str(context.info_name)]]
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if name in NO_MATTER or source is None or source.name != "COMMANDLINE":
            continue
        value = context.params[name]
        values = [str(one) for one in (value if isinstance(value, list) else [value])]
        if parameter.param_type_name == "argument":
            parts[0] += values
        elif value is True:
            parts.append([parameter.opts[0]])
        else:
            parts += [[parameter.opts[0], one] for one in values]
    return [shlex.join(part) for part in parts]
