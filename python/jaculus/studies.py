"""Studies: grids of computed figures beside a source's."""
from __future__ import annotations

import json
import os
from typing import Any, Callable, Optional, Union

from . import _core
from ._inputs import Source, node_of, whole
from ._interrupts import Interrupted
from ._progress import show_point, shown
from ._tables import page, pandas, pyplot


class Study:
    """A finished study.

    Attributes:
        columns: of its rows, units in the names.
        complete: False where points are missing.
        figures: the content of study.json: rows, the source's figures beside the computed ones, notes.
        summary: what `jaculus study` prints.
    """

    def __init__(self, core: _core.Study):
        self._core = core
        self.columns: list[str] = core.columns
        self.complete: bool = core.complete
        self.figures: dict[str, Any] = json.loads(core.json)
        self.summary: str = core.summary

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row a grid point."""
        return pandas().DataFrame(self.figures["rows"], columns=self.columns)

    def plot(self, x: str, y: str, by: Optional[str] = None) -> Any:
        """One column over another, a line for each value of `by`; returns the matplotlib figure."""
        frame = self.to_pandas()
        figure, axis = pyplot().subplots(layout="constrained")
        for value, part in ([(None, frame)] if by is None else frame.groupby(by)):
            axis.plot(part[x], part[y], label=None if by is None else f"{by} {value}")
        axis.set_xlabel(x)
        axis.set_ylabel(y)
        if by is not None:
            axis.legend()
        return figure

    def __repr__(self) -> str:
        return f"<jaculus.Study {self.figures['name']}: {len(self.figures['rows'])} rows>"

    def _repr_html_(self) -> str:
        return page(self._core.report_html())


def study(source: Source, *, out: Union[str, "os.PathLike[str]", None] = None, jobs: int = 1,
          resume: bool = False, progress: Union[bool, Callable[[int, int], None], None] = None) -> Study:
    """Runs a study: reorientation, tail design, drag bench, plans over grids of parameters.

    Args:
        source: a YAML file, the name of one that comes with jaculus ("fig4_shaft"), or a dict with its
            keys.
        out: folder for study.csv, study.json and report.html, and for what is finished of a run that
            was interrupted.
        jobs: processes at a time.
        resume: insist on going on with what is finished in `out`.
        progress: called after every point with how many are done, and how many there are. What it
            raises ends the study. True: a bar of tqdm.

    Raises:
        InputError: with file, line and key, before any work is done.
        Interrupted: Ctrl-C; `result` has what is finished.
    """
    jobs = whole("jobs", jobs, 1, 1024)
    with shown(progress, "study", show_point, "point") as call:
        core = _core.study(node_of(source), "" if out is None else os.fspath(out), jobs, resume, call)
    if core.interrupted:
        kept = "result has what is finished" + ("" if out is None else ", `out` too")
        raise Interrupted(f"interrupted; {kept}", Study(core))
    return Study(core)
