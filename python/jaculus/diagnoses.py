"""Diagnosis: where robot and model part, and which effect causes it."""
from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Callable, Iterable, Optional, Union

from . import _core
from ._errors import InputError
from ._inputs import Source, node_of, quantity, whole
from ._progress import show_stage, shown
from ._results import Result
from ._tables import pandas, pyplot
from .datasets import Dataset, load_dataset
from .effects import Effect, compiled


class Diagnosis(Result):
    """What a diagnosis found. `save` writes diagnosis.json, augmented.yaml and report.html.

    Attributes:
        verdict: "none", "effect", "several", "partial", "ambiguous", "unexplained" or "insufficient".
        effects: what the verdict names, most probable first: name, probability, parameters with value,
            95 % interval and unit.
        gap: root-mean-square error on held-out trials before and after the effect is added [noise
            floors], and by how much of it the gap shrinks.
        reasons: why this verdict, or what to record next time.
        augmented: the model with the effect added, as YAML; `simulate` takes a file of it.
        summary, json, figures: what `jaculus diagnose` prints; the text of diagnosis.json, its content.
    """

    def __init__(self, core: _core.Diagnosis):
        super().__init__(core)
        self.verdict: str = self.figures["verdict"]
        self.effects: list[dict[str, Any]] = self.figures["effects"]
        self.gap: dict[str, Any] = self.figures["gap"]
        self.reasons: list[str] = self.figures["reasons"]
        self.augmented: str = core.augmented

    def to_pandas(self) -> Any:
        """The ranking of effects as a pandas.DataFrame: log evidence relative to none, held-out error
        [noise floors], probability."""
        return pandas().DataFrame(self.figures["ranking"])

    def plot(self, most: int = 10) -> Any:
        """The most probable explanations as bars; returns the matplotlib figure."""
        rows = sorted(self.figures["ranking"], key=lambda row: row["probability"] or 0.0)[-most:]
        figure, axis = pyplot().subplots(figsize=(7, 0.6 + 0.35 * len(rows)), layout="constrained")
        axis.barh([row["effect"] for row in rows], [row["probability"] or 0.0 for row in rows])
        axis.set_xlim(0.0, 1.0)
        axis.set_xlabel("probability [-]")
        axis.set_title(f"verdict: {self.verdict}")
        return figure

    def __repr__(self) -> str:
        named = ", ".join(effect["name"] for effect in self.effects)
        return f"<jaculus.Diagnosis: {self.verdict}{': ' + named if named else ''}>"


Given = Union[Dataset, str, "os.PathLike[str]"]


def diagnose(datasets: Union[Given, Iterable[Given]], *, settings: Optional[Source] = None,
             tolerances: Optional[Mapping[str, Union[str, float]]] = None,
             horizon: Union[str, float, None] = None,
             effect_files: Iterable[Union[str, "os.PathLike[str]"]] = (),
             own_effects: Union[Effect, Iterable[Effect]] = (), jobs: int = 2,
             progress: Union[bool, Callable[[str], None], None] = None) -> Diagnosis:
    """Finds where the gap between model and robot lies and which unmodelled effect causes it.

    Args:
        datasets: a `Dataset` or its folder; several are diagnosed together, an operating condition
            each of one robot.
        settings: a YAML file or a dict of settings that replace defaults; `jaculus diagnose --explain`
            lists them.
        tolerances: held-out errors that are good enough, by channel: {"x": "5 mm", "pitch": "1 deg"};
            plain numbers are SI.
        horizon: since the start, up to which errors are judged ("0.1 s" or [s]); None: the whole motion.
        effect_files: YAML files of effects of your own, judged beside the others.
        own_effects: the same in Python; slow.
        jobs: threads at a time; the result does not depend on it.
        progress: called with the name of each stage as it begins. What it raises ends the diagnosis.
            True: a bar of tqdm.

    Raises:
        InputError: with file, line and key.
        KeyboardInterrupt: Ctrl-C. Nothing half done is kept.

    Source: docs/diagnosis.md has the mathematics.
    """
    jobs = whole("jobs", jobs, 1, 1024)
    if tolerances is not None and not isinstance(tolerances, Mapping):
        raise InputError.of("tolerances", f"{tolerances!r} given; allowed: a dict {{CHANNEL: SIZE}}")
    many = [datasets] if isinstance(datasets, (Dataset, str, os.PathLike)) else list(datasets)
    loaded = [d if isinstance(d, Dataset) else load_dataset(d) for d in many]
    with shown(progress, "diagnosis", show_stage, "stage") as call:
        return Diagnosis(_core.diagnose(
            [dataset._core for dataset in loaded],
            None if settings is None else node_of(settings),
            [f"{channel}={quantity(value, 'SI')}" for channel, value in (tolerances or {}).items()],
            "" if horizon is None else quantity(horizon, "s"),
            [os.fspath(file) for file in effect_files], compiled(own_effects), jobs, call))
