"""The layout of C, which is clang-format's business."""

import json
import subprocess

from clang_format import get_executable

from hydroservo.errors import LoopError
from hydroservo.export.comments import WIDTH

STYLE = {
    "BasedOnStyle": "LLVM",
    "IndentWidth": 4,
    "ColumnLimit": WIDTH,
    "AlignAfterOpenBracket": "BlockIndent",
    "AllowShortFunctionsOnASingleLine": "None",
    "BinPackArguments": False,
    "BinPackParameters": False,
    "BreakBeforeBinaryOperators": "NonAssignment",
    "MaxEmptyLinesToKeep": 1,
    "PenaltyReturnTypeOnItsOwnLine": 1000,
    "ReflowComments": False,
    "SortIncludes": False,
}


def formatted(text: str) -> str:
    """A text of C with the indentation and the line breaks of one style."""
    command = [get_executable("clang-format"), f"--style={json.dumps(STYLE)}", "--assume-filename=x.c"]
    try:
        done = subprocess.run(  # noqa: S603 - a library's own program
            command, input=text.encode(), capture_output=True, check=True
        )
    except (OSError, subprocess.CalledProcessError) as error:
        raise LoopError(f"clang-format, which formats exported C, does not run here: {error}") from None
    return done.stdout.decode()
