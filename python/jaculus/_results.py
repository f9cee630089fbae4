"""What results share: texts, figures and files of the command that gives the same."""
from __future__ import annotations

import json
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, Union

from ._tables import page

if TYPE_CHECKING:
    from pathlib import Path


class Result:
    """A result of the library. In a notebook it shows its report, with charts and animation."""

    def __init__(self, core: Any):
        self._core = core

    @cached_property
    def summary(self) -> str:
        """What the command prints."""
        return self._core.summary

    @cached_property
    def json(self) -> str:
        """The text of the JSON file that the command writes."""
        return self._core.json

    @cached_property
    def figures(self) -> dict[str, Any]:
        """The content of that file, SI, see docs/commands.md; None where a figure doesn't apply."""
        return json.loads(self.json)

    def save(self, folder: Union[str, "os.PathLike[str]"]) -> Path:
        """Writes the files that the command writes into its `--out`, report.html among them."""
        from pathlib import Path
        self._core.save(os.fspath(folder))
        return Path(folder)

    def _repr_html_(self) -> str:
        return page(self._core.report_html())
