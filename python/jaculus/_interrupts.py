"""Ctrl-C while the library computes."""
from __future__ import annotations

from typing import Any


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a computation that had something to keep.

    Attributes:
        result: what it would have returned, as far as it came: a `Plan` at its last iterate, the
            trials or the rows that were finished.
    """

    def __init__(self, message: str, result: Any):
        super().__init__(message)
        self.result = result
