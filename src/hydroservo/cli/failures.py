"""How a command fails: one line on stderr and an exit status, never a traceback for what a user can mend."""

import sys
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from hydroservo.cli.interrupts import INTERRUPTED, heard
from hydroservo.errors import HydroservoError, HydroservoWarning

__all__ = ["Commands"]

USER_ERROR = 2


class Commands(TyperGroup):
    """The commands, with what they raise turned into a message and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", HydroservoWarning)  # a result has them; the command says them
                result = super().invoke(ctx)
            sys.stdout.flush()
        except HydroservoError as error:
            raise failed(str(error), USER_ERROR) from error
        except KeyboardInterrupt as error:
            heard()
            raise typer.Exit(INTERRUPTED) from error
        except BrokenPipeError as error:
            raise typer.Exit(1) from error  # the reader, such as head, has all it wants
        except OSError as error:
            raise failed(described(error), USER_ERROR) from error
        return result


def failed(message: str, status: int) -> typer.Exit:
    typer.echo(f"hydroservo: {message}", err=True)
    return typer.Exit(status)


def described(error: OSError) -> str:
    parts = (error.filename, error.strerror or " ".join(str(error).split()))
    return ": ".join(str(part) for part in parts if part)
