"""The exception of bad input; the library raises it."""
from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Optional, Union


class InputError(ValueError):
    """Bad input: a file, a value or a name that can't be used.

    The message is complete: file:line, key, what was given, what is allowed.

    Attributes:
        file: the file's path, "dict" for a dict, "table" for one of pandas; None where the fault is in
            none.
        line: in the file, from 1 on; None where unknown. Of a dict: in its JSON.
        key: where in the file, as "phases[0].duration", or the argument of a call; None where unknown.
    """

    file: Optional[str] = None
    line: Optional[int] = None
    key: Optional[str] = None

    @classmethod
    def of(cls, key: str, fault: str, place: str = "") -> InputError:
        """Of a value that a call was given, or a map at `place`."""
        error = cls(f"{place}{': ' if place else ''}{key}: {fault}")
        error.key = key
        return error

    @classmethod
    def told(cls, message: str, file: Union[str, "os.PathLike[str]"]) -> InputError:
        """What the command said of a file, "FILE:LINE: fault" or "FILE: fault" where it is in it."""
        error, name = cls(message), re.escape(os.fspath(file))
        place = re.match(rf"{name}(?::(\d+))?: ", message)
        if place:
            error.file = os.fspath(file)
            error.line = int(place[1]) if place[1] else None
        return error


@contextmanager
def reading(file: Union[str, "os.PathLike[str]"]) -> Iterator[None]:
    """What is raised within names no other place: it is this file's fault."""
    try:
        yield
    except InputError as error:
        if error.file is None and error.key is None:
            error.file = os.fspath(file)
        raise
