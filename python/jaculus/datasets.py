"""Datasets: logs of a robot, measured or simulated."""
from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Optional, Union

from . import _core
from ._errors import InputError
from ._inputs import Source, node_of, whole_or_none
from ._interrupts import Interrupted
from ._tables import labelled, page, pandas, pyplot, xarray
from .effects import Effect, compiled
from .plans import Plan

if TYPE_CHECKING:
    import numpy as np


class Stream:
    """Samples of one sensor system in one trial. Channels are items: ``stream["x"]``, shape (n,); an
    empty cell of a log is NaN.

    Attributes:
        name: "mocap", "joints", ...
        rate_hz: as stated [Hz]; NaN where the samples alone tell.
        time: (n,) [s].
        channels, units: names of the c channels, and their SI units by name.
        values: (n, c).
    """

    def __init__(self, core: _core.Stream):
        self._core = core
        self.name: str = core.name
        self.rate_hz: float = core.rate_hz
        self.channels: list[str] = core.channels
        self.units: dict[str, str] = dict(zip(core.channels, core.units))

    # Arrays are made when they are asked for, as those of plans.
    @cached_property
    def time(self) -> np.ndarray:
        return self._core.time.copy()

    @cached_property
    def values(self) -> np.ndarray:
        return self._core.values.copy(order="K").T

    def __getitem__(self, channel: str) -> np.ndarray:
        if channel not in self.units:
            raise KeyError(f"{channel}; channels are {', '.join(self.channels)}")
        return self.values[:, self.channels.index(channel)]

    def to_pandas(self) -> Any:
        """A pandas.DataFrame of the channels, indexed by time [s]; units are in ``attrs["units"]``."""
        index = pandas().Index(self.time, name="time")
        frame = pandas().DataFrame(self.values, columns=self.channels, index=index)
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_xarray(self) -> Any:
        """An xarray.Dataset with a variable a channel over time [s]; each has its `units`."""
        data = {name: ("time", self[name], {"units": self.units[name]}) for name in self.channels}
        return xarray().Dataset(data, {"time": ("time", self.time, {"units": "s"})})

    def __repr__(self) -> str:
        return f"<jaculus.Stream {self.name}: {len(self.time)} samples of {', '.join(self.channels)}>"


class Trial:
    """One run of an experiment. Streams are items: ``trial["mocap"]``.

    Attributes:
        name: "trial_01".
        streams: by name.
    """

    def __init__(self, core: _core.Trial):
        self.name: str = core.name
        self.streams: dict[str, Stream] = {s.name: Stream(s) for s in core.streams}

    def __getitem__(self, stream: str) -> Stream:
        return self.streams[stream]

    def __repr__(self) -> str:
        return f"<jaculus.Trial {self.name}: {', '.join(self.streams)}>"


class Dataset:
    """What sensors saw in trials of one experiment.

    Attributes:
        experiment: "leap", "self_righting", "tail_bench" or "pendulum".
        robot: as stated, a name or a folder.
        trials: the `Trial`s.
        provenance: where it is from.
        notes: what its files leave open and what was taken for it, a sentence each.
        folder: where it lies; None where it was simulated and not saved.
        summary: text on it: of a simulated one, what `jaculus simulate` prints.
        figures: of a simulated one, the content of summary.json: ends, events, ranges left,
            figures of leaps.
    """

    def __init__(self, core: _core.Dataset, simulated: Optional[_core.Trials] = None):
        self._core = core
        self.experiment: str = core.experiment
        self.robot: str = core.robot
        self.trials: list[Trial] = [Trial(trial) for trial in core.trials]
        self.provenance: str = core.provenance
        self.notes: list[str] = core.notes
        self.folder: Optional[Path] = core.folder if str(core.folder) not in ("", ".") else None
        self.figures: dict[str, Any] = json.loads(simulated.json) if simulated else {}
        self._simulated = simulated

    @cached_property
    def summary(self) -> str:
        if self._simulated:
            return self._simulated.summary
        lines = [f"{self.experiment} of {self.robot}, {len(self.trials)} trials"]
        lines += [f"  {trial.name}: " + ", ".join(f"{s.name} ({len(s.time)} samples of {len(s.channels)} "
                                                  "channels)" for s in trial.streams.values())
                  for trial in self.trials]
        return "\n".join(lines + [f"note: {note}" for note in self.notes])

    @property
    def _title(self) -> str:
        return self.folder.resolve().name if self.folder else self.figures.get("experiment", "dataset")

    def to_pandas(self, stream: str) -> Any:
        """A stream of all trials as a pandas.DataFrame, indexed by trial and time [s]."""
        parts = {t.name: t[stream].to_pandas() for t in self.trials if stream in t.streams}
        if not parts:
            names = sorted({name for trial in self.trials for name in trial.streams})
            raise KeyError(f"{stream}; streams are {', '.join(names)}")
        frame = pandas().concat(parts, names=["trial"])
        frame.attrs["units"] = {n: u for part in parts.values() for n, u in part.attrs["units"].items()}
        return frame

    def plot(self, stream: str = "mocap") -> Any:
        """Every channel of a stream over time, all trials; returns the matplotlib figure."""
        trials = [trial for trial in self.trials if stream in trial.streams]
        if not trials:
            raise KeyError(stream)
        first = trials[0][stream]
        figure, axes = pyplot().subplots(len(first.channels), 1, sharex=True, squeeze=False,
                                         figsize=(7, 1.6 * len(first.channels)), layout="constrained")
        for axis, channel in zip(axes[:, 0], first.channels):
            for trial in trials:
                if channel in trial[stream].units:
                    axis.plot(trial[stream].time, trial[stream][channel], linewidth=0.8, label=trial.name)
            axis.set_ylabel(labelled(channel, first.units[channel]).replace(" [", "\n["), fontsize="small")
        axes[-1, 0].set_xlabel("time [s]")
        return figure

    def save(self, folder: Union[str, "os.PathLike[str]"]) -> Path:
        """Writes dataset.yaml, the trials and report.html; summary.json of a simulated one."""
        self._core.save(os.fspath(folder), self._title)
        self.folder = Path(folder)
        if self.figures:
            (self.folder / "summary.json").write_text(json.dumps(self.figures, indent=1) + "\n")
        return self.folder

    def __repr__(self) -> str:
        return f"<jaculus.Dataset: {self.experiment} of {self.robot}, {len(self.trials)} trials>"

    def _repr_html_(self) -> str:
        return page(self._core.report_html(self._title))


def load_dataset(folder: Union[str, "os.PathLike[str]"]) -> Dataset:
    """Reads a dataset's folder, the one with dataset.yaml.

    Raises:
        InputError: with file and line: a missing file, time that runs backwards, a unit of another
            dimension, ...
    """
    return Dataset(_core.load_dataset(os.fspath(folder)))


def _effect(name: str, parameters: Union[Mapping[str, float], float, str]) -> str:
    if not isinstance(parameters, Mapping):
        return f"{name}:{parameters}"
    return f"{name}:" + ",".join(f"{key}={float(value)!r}" for key, value in parameters.items())


def _effects(given: Union[Mapping[str, Mapping[str, float]], Iterable[str], str, None]) -> list[str]:
    if given is None:
        return []
    if isinstance(given, Mapping):
        return [_effect(name, parameters) for name, parameters in given.items()]
    texts = [given] if isinstance(given, str) else list(given)
    for text in texts:
        if not isinstance(text, str):
            raise InputError.of("effects", f"{text!r} given; allowed: texts \"NAME:PARAMETER=VALUE\", or a "
                                           "dict {NAME: {PARAMETER: VALUE}}")
    return texts


def _experiment(source: Source, robot: Union[str, "os.PathLike[str]", None], controller: str) -> _core.Experiment:
    if isinstance(source, Mapping):
        return _core.load_experiment(node_of(source))
    file = Path(_core.find_problem_file(os.fspath(source)))
    if file.is_dir():
        file = file / "plan.csv"
    if file.suffix != ".csv":
        if robot is not None or controller:
            raise ValueError("robot and controller are for a plan; an experiment states its own")
        return _core.load_experiment(_core.Node.load(file))
    if robot is None:
        raise ValueError(f"{file}: a plan needs `robot`, a folder or a name")
    return _core.plan_experiment(file, os.fspath(robot), controller)


def simulate(experiment: Source, *, robot: Union[str, "os.PathLike[str]", None] = None, controller: str = "",
             trials: Optional[int] = None, seed: Optional[int] = None,
             effects: Union[Mapping[str, Mapping[str, float]], Iterable[str], str, None] = None,
             effect_files: Iterable[Union[str, "os.PathLike[str]"]] = (),
             own_effects: Union[Effect, Iterable[Effect]] = (),
             augmented: Union[str, "os.PathLike[str]"] = "") -> Dataset:
    """Plays an experiment, or a plan, on a simulated robot with sensors and noise.

    Args:
        experiment: a YAML file, the name of one that comes with jaculus ("leap_trials"), or a dict
            with its keys; or a plan: its CSV file or its folder.
        robot: that a plan is played on, a folder or a name.
        controller: that a plan is played with, in YAML as in dataset.yaml; feed-forward torque and
            joint PD where empty.
        trials, seed: in place of the experiment's.
        effects: of the plant that no model knows, SI: {"tail_compliance": {"stiffness": 98}}, or texts
            "tail_compliance:stiffness=98".
        effect_files: YAML files of effects of your own, for `effects`.
        own_effects: the same in Python; slow.
        augmented: augmented.yaml of a diagnosis: its effects too. Those of Python must be given too.

    Raises:
        InputError: with file, line and key.
        Interrupted: Ctrl-C; `result` has the trials that are done.
    """
    if isinstance(experiment, Plan):
        raise TypeError("simulate plays a plan from its files: plan.save(folder), then simulate(folder)")
    trials, seed = whole_or_none("trials", trials, 1, 100000), whole_or_none("seed", seed, 0)
    read = _experiment(experiment, robot, controller)
    done = _core.simulate(read, trials, seed, _effects(effects), [os.fspath(f) for f in effect_files],
                          os.fspath(augmented), compiled(own_effects))
    dataset = Dataset(done.dataset, done)
    if done.interrupted:
        raise Interrupted(f"{read.name}: interrupted; result has the trials that are done", dataset)
    return dataset
