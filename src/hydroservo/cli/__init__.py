"""The command line."""

from hydroservo.cli.interrupts import (
    INTERRUPTED,
    discard_unwritten,
    end_on_interrupt,
    ignore_interrupts,
    leave,
    repeat_interrupts,
)

__all__ = ["main"]


def main() -> None:
    """The ``hydroservo`` command.

    An interrupt before it is called is Python's own matter: this module and those above it import next to
    nothing, so that it is called soon.
    """
    end_on_interrupt()
    from hydroservo.cli.environment import prepare_environment

    prepare_environment()
    from hydroservo.cli.commands import app

    try:
        repeat_interrupts()
        try:
            app(prog_name="hydroservo")
        finally:
            ignore_interrupts()
    except KeyboardInterrupt:  # outside of any command, which would have heard it
        leave()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            leave()
        raise
    finally:
        discard_unwritten()
