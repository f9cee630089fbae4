"""The exception of bad input; the library raises it."""
from __future__ import annotations

from typing import Optional


class InputError(ValueError):
    """Bad input: a file, a value or a name that can't be used.

    The message is complete: file:line, key, what was given, what is allowed.

    Attributes:
        file: the file's path, "dict" for a dict; None where the fault is in no file.
        line: in the file, from 1 on; None where unknown. Of a dict: in its JSON.
        key: where in the file, as "phases[0].duration"; None where unknown.
    """

    file: Optional[str] = None
    line: Optional[int] = None
    key: Optional[str] = None
