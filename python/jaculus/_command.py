"""The command `jaculus`: the program that the package brings along."""
from __future__ import annotations

import os
import sys
from pathlib import Path


def program() -> Path:
    """The file of the program."""
    return Path(__file__).absolute().parent / "bin" / "jaculus"


def main() -> None:
    file = str(program())
    os.execv(file, [file, *sys.argv[1:]])
