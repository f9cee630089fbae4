"""The command `jaculus`: the program that the package brings along, and what Python does of it."""
from __future__ import annotations

import os
import sys
from pathlib import Path


def program() -> Path:
    """The file of the program."""
    return Path(__file__).absolute().parent / "bin" / "jaculus"


def main() -> None:
    arguments = sys.argv[1:]
    if arguments[:1] == ["import"]:
        from ._import_command import KINDS, run
        if arguments[1:2] and arguments[1] in KINDS:
            sys.exit(run(arguments[1:]))
    file = str(program())
    os.execv(file, [file, *arguments])
