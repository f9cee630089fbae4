"""Preflight: what a planned experiment could tell, before it is done."""
from __future__ import annotations

import os
from math import nan
from typing import TYPE_CHECKING, Any, Callable, Iterable, Optional, Union

from . import _core
from ._errors import InputError
from ._inputs import Source, node_of, whole, whole_or_none
from ._progress import show_stage, shown
from ._results import Result
from ._tables import pandas, pyplot
from .effects import Effect, compiled

if TYPE_CHECKING:
    import numpy as np


class Preflight(Result):
    """What a planned experiment would show, and what could not be told apart by it. `save` writes
    preflight.json and report.html.

    Attributes:
        possible: whether data of the experiment could be diagnosed at all; `reasons` say why not.
        reasons, notes: a sentence each.
        effects: a dict each, in the order of the catalogue: name, caption, parameter, unit; visible
            (changes anything that is recorded); stated, the value at work [unit]; named (whether it
            would be), log_odds against no effect, gap [noise floors]; least, the value from which it
            would be named [unit], None where there is none within its bounds.
        pairs: a dict each: effects, tellable, at_work, chance_told and expected_log_bayes_factor both ways, told_by:
            sensors and motions that would tell them apart, best first.
        sets: names of effects that pairs not tellable connect.
        next: experiments that could follow, the most informative first: experiment, information_bit,
            pairs_told.
        information, uncertainty: on which effect is at work, by this experiment, and at most [bit];
            NaN where there is none.
        summary, json, figures: what `jaculus preflight` prints; the text of preflight.json, its content.
    """

    def __init__(self, core: _core.Preflight):
        super().__init__(core)
        self.possible: bool = self.figures["possible"]
        self.reasons: list[str] = self.figures["reasons"]
        self.notes: list[str] = self.figures["notes"]
        self.effects: list[dict[str, Any]] = self.figures["effects"]
        self.pairs: list[dict[str, Any]] = self.figures["pairs"]
        self.sets: list[list[str]] = self.figures["sets"]
        self.next: list[dict[str, Any]] = self.figures["next"]
        self.information: float = _number(self.figures["information_bit"])
        self.uncertainty: float = _number(self.figures["uncertainty_bit"])

    @property
    def names(self) -> list[str]:
        """Names of the n effects, in the order of `log_bayes_factors`."""
        return [effect["name"] for effect in self.effects]

    @property
    def log_bayes_factors(self) -> np.ndarray:
        """(n, n) [-]: how firmly effect i at work is told from effect j, the expected log Bayes factor;
        NaN on the diagonal, and where i would not be named."""
        import numpy as np
        names = self.names
        factors = np.full((len(names), len(names)), np.nan)
        for pair in self.pairs:
            i, j = (names.index(name) for name in pair["effects"])
            factors[i, j], factors[j, i] = map(_number, pair["expected_log_bayes_factor"])
        return factors

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row an effect, indexed by name."""
        return pandas().DataFrame(self.effects).set_index("name") if self.effects else pandas().DataFrame()

    def pairs_to_pandas(self) -> Any:
        """A pandas.DataFrame with a row a pair of effects: a, b, tellable, a_from_b and b_from_a (expected
        log Bayes factors with the former at work), told_by."""
        return pandas().DataFrame([
            {"a": pair["effects"][0], "b": pair["effects"][1], "tellable": pair["tellable"],
             "a_from_b": _number(pair["expected_log_bayes_factor"][0]),
             "b_from_a": _number(pair["expected_log_bayes_factor"][1]),
             "told_by": ", ".join(change["name"] for change in pair["told_by"])} for pair in self.pairs])

    def plot(self) -> Any:
        """From which size on each effect would be named, in its prior's scales, a bar each; effects without
        a bar would not be. Returns the matplotlib figure."""
        effects = sorted(self.effects, key=lambda e: _number(e["least_of_prior_scale"]), reverse=True)
        figure, axis = pyplot().subplots(figsize=(7, 0.8 + 0.3 * max(1, len(effects))), layout="constrained")
        axis.barh([effect["name"] for effect in effects],
                  [_number(effect["least_of_prior_scale"]) for effect in effects])
        axis.set_xscale("log")
        axis.set_xlabel("named from this size on [prior scales]")
        axis.set_title(self.figures["experiment"])
        return figure

    def __repr__(self) -> str:
        if not self.possible:
            return f"<jaculus.Preflight: {self.reasons[0]}>"
        seen = sum(effect["least"] is not None for effect in self.effects)
        mixed = sum(not pair["tellable"] for pair in self.pairs)
        return (f"<jaculus.Preflight: {seen} of {len(self.effects)} effects could be named, {mixed} pairs "
                "not told apart>")


def _number(value: Optional[float]) -> float:
    return nan if value is None else value


def preflight(experiment: Source, *, trials: Optional[int] = None, seed: Optional[int] = None,
              size: float = 1.0, settings: Optional[Source] = None,
              effect_files: Iterable[Union[str, "os.PathLike[str]"]] = (),
              own_effects: Union[Effect, Iterable[Effect]] = (), alternatives: bool = True,
              jobs: int = 2, progress: Union[bool, Callable[[str], None], None] = None) -> Preflight:
    """Says before an experiment which effects its data would show, from which size on, which of them could
    not be told apart, by what sensor or motion they could, and what to do next. Simulates: a minute for a
    pendulum, some for a leap.

    Args:
        experiment: a YAML file, the name of one that comes with jaculus ("pendulum_trials"), or a dict
            with its keys.
        trials, seed: in place of the experiment's.
        size: of each effect at work [probing steps of its parameter: a prior scale unless it states
            another].
        settings: a YAML file or a dict of settings that replace defaults, as for `diagnose`.
        effect_files: YAML files of effects of your own, judged beside the others.
        own_effects: the same in Python; slow.
        alternatives: whether to look for sensors and motions that would tell more; without, it is some
            times as fast.
        jobs: threads at a time; the result does not depend on it.
        progress: called with the name of each stage as it begins. What it raises ends the preflight.
            True: a bar of tqdm.

    Raises:
        InputError: with file, line and key.
        KeyboardInterrupt: Ctrl-C. Nothing half done is kept.

    Source: docs/diagnosis.md; M. Krysander and E. Frisk, 2008; E. Eriksson, E. Frisk and M. Krysander,
    2013.
    """
    if not 1e-3 <= size <= 1e3:
        raise InputError.of("size", f"{size} given; allowed: 0.001 to 1000")
    trials, seed = whole_or_none("trials", trials, 1, 100000), whole_or_none("seed", seed, 0)
    jobs = whole("jobs", jobs, 1, 1024)
    with shown(progress, "preflight", show_stage, "stage") as call:
        return Preflight(_core.preflight(
            _core.load_experiment(node_of(experiment)), trials, seed, size,
            None if settings is None else node_of(settings), [os.fspath(file) for file in effect_files],
            compiled(own_effects), alternatives, jobs, call))
