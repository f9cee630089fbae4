"""Plans: solve, compare."""
from __future__ import annotations

import json
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, Callable, Iterable, Mapping, Optional, Union

from . import _core
from ._errors import InputError
from ._inputs import Source, whole, whole_or_none
from ._interrupts import Interrupted
from ._results import Result
from ._tables import labelled, page, pandas, pyplot, xarray
from ._progress import show_iteration, shown
from .robots import Problem, load_problem
from .terms import Term

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from ._exports import JointTrajectory

Progress = Union[bool, Callable[[int, float, float], None]]


class Plan(Result):
    """A solved problem: a motion of the robot with its torques. n samples; at the border of two
    phases one instant stands twice.

    Columns of plan.csv are items: ``plan["x"]``, ``plan["tail_torque"]``, shape (n,). `save` writes
    plan.csv, summary.json, solution.json and report.html.

    Attributes:
        status: "optimal", "acceptable", "infeasible", "iteration_limit", "interrupted", ...
        converged: whether first-order conditions hold; else arrays are those of the last iterate.
        time: (n,) [s].
        state_names, states: 2c names, (n, 2c): the coordinates [m or rad], then their rates [m/s or
            rad/s].
        input_names, inputs: u names, (n, u): torque of one motor at its joint [N m, or N where it
            slides].
        foot_names, forces: f names, (n, f, 2): forces of the floor on the feet, x and z, left and
            right summed [N].
        phase: n names of phases.
        columns, units: names of the columns of plan.csv, and their units by name.
        summary: what `jaculus solve` prints: objective, durations, motors against their limits, what
            holds the plan back, verification.
        json, figures: the text of summary.json, its content.
    """

    def __init__(self, core: _core.Plan):
        super().__init__(core)
        self.status: str = core.status
        self.converged: bool = core.converged
        coordinates = core.coordinates
        self.state_names: list[str] = coordinates + [f"{name}_velocity" for name in coordinates]
        self.input_names: list[str] = core.motors
        self.foot_names: list[str] = core.feet

    # Arrays and the table are made when they are asked for: NumPy's import takes longer than all
    # else that Python does for a leap.
    @cached_property
    def time(self) -> np.ndarray:
        return self._core.time

    @cached_property
    def states(self) -> np.ndarray:
        import numpy as np
        return np.concatenate([self._core.position, self._core.velocity]).T

    @cached_property
    def inputs(self) -> np.ndarray:
        return self._core.torque.T

    @cached_property
    def forces(self) -> np.ndarray:
        import numpy as np
        return np.stack([self._core.force_x.T, self._core.force_z.T], axis=-1)

    @cached_property
    def _table(self) -> _core.Table:
        return self._core.table

    @cached_property
    def _values(self) -> np.ndarray:
        return self._table.values.copy(order="K")

    @cached_property
    def columns(self) -> list[str]:
        return self._table.names

    @cached_property
    def units(self) -> dict[str, str]:
        return dict(zip(self.columns, self._table.units))

    @cached_property
    def phase(self) -> list[str]:
        return self._table.phase

    @property
    def problem(self) -> Problem:
        """The problem as it was solved."""
        return Problem(self._core.problem)

    @property
    def objective(self) -> float:
        """In the problem's sense and unit; NaN where there is none."""
        value = self.figures["objective"]
        return float("nan") if value is None else value

    @property
    def history(self) -> Any:
        """The solver's iterations as a pandas.DataFrame."""
        table = self._core.history
        return pandas().DataFrame(table.values.copy(order="K"), columns=table.names)

    def __getitem__(self, column: str) -> np.ndarray:
        if column not in self.units:
            raise KeyError(f"{column}; columns are {', '.join(self.columns)}")
        return self._values[:, self.columns.index(column)]

    def to_pandas(self) -> Any:
        """plan.csv as a pandas.DataFrame, indexed by time [s]; units are in ``attrs["units"]``."""
        frame = pandas().DataFrame(self._values, columns=self.columns)
        if self.phase:
            frame.insert(1, "phase", self.phase)
        frame = frame.set_index("time")
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self) -> Any:
        """Coordinates, torques and forces on the feet over time; returns the matplotlib figure."""
        half = len(self.state_names) // 2
        figure, axes = pyplot().subplots(3, 1, sharex=True, figsize=(7, 7), layout="constrained")
        for values, names, axis, label in (
                (self.states[:, :half], self.state_names[:half], axes[0], "coordinates [m, rad]"),
                (self.inputs, self.input_names, axes[1], "torque [N m]"),
                (self.forces[:, :, 1], self.foot_names, axes[2], "normal force [N]")):
            for k, name in enumerate(names):
                axis.plot(self.time, values[:, k], label=name)
            axis.set_ylabel(label)
            if names:
                axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")
        axes[-1].set_xlabel("time [s]")
        axes[0].set_title(self._core.problem.name)
        return figure

    def to_xarray(self) -> Any:
        """An xarray.Dataset: `states` (time, state), `inputs` (time, input), `forces` (time, foot, axis), and
        `phase`; `state_units` has the unit of each state [N m of inputs, N of forces]."""
        xr = xarray()
        time = ("time", self.time, {"units": "s"})
        data: dict[str, Any] = {
            "states": (("time", "state"), self.states), "inputs": (("time", "input"), self.inputs),
            "forces": (("time", "foot", "axis"), self.forces, {"units": "N"})}
        if self.phase:
            data["phase"] = ("time", self.phase)
        frame = xr.Dataset(data, {"time": time, "state": self.state_names, "input": self.input_names,
                                  "foot": self.foot_names, "axis": ["x", "z"]})
        return frame.assign_coords(state_units=("state", [self.units[name] for name in self.state_names]))

    def to_joints(self, *, rate: float = 500.0, even_unsolved: bool = False) -> JointTrajectory:
        """Positions, velocities and torques of the joints of the robot's own file, by their names, as
        `jaculus export` writes them: for Pinocchio, Crocoddyl, MuJoCo or a controller.

        Args:
            rate: samples a second [Hz].
            even_unsolved: take a plan whose solve did not converge.
        """
        from ._exports import JointTrajectory
        return JointTrajectory(self._core, rate, even_unsolved)

    def to_bag(self, path: Union[str, "os.PathLike[str]"], *, rate: float = 500.0, start: float = 0.0,
               even_unsolved: bool = False) -> Path:
        """Writes a ROS 2 bag for PlotJuggler, Foxglove and players, by PyPI's rosbags.

        The plan is resampled as `jaculus export` does. /joint_trajectory has it as one
        trajectory_msgs/JointTrajectory, /joint_states as sensor_msgs/JointState a sample. Joints are those of
        the robot's file, left and right written out with its signs; held ones stand at their place. Effort is
        the torque at the joint, of one motor [N m].

        Args:
            path: "NAME.mcap" for one MCAP file (replaced); anything else is a new folder, a bag in sqlite3.
            rate: samples a second [Hz].
            start: stamp of the first sample, since the epoch [s].
            even_unsolved: write a plan whose solve did not converge.
        """
        from ._exports import write_bag
        return write_bag(self._core, path, rate, start, even_unsolved)

    def to_rerun(self, path: Union[str, "os.PathLike[str]"], *, rate: float = 500.0,
                 even_unsolved: bool = False) -> Path:
        """Writes a recording for Rerun, NAME.rrd: joints/NAME/position, velocity, effort, resampled as
        `to_bag` has them, and the columns of plan.csv as plan/NAME. Needs rerun-sdk."""
        from ._exports import write_rerun
        return write_rerun(self, path, rate, even_unsolved)

    def __repr__(self) -> str:
        return f"<jaculus.Plan {self._core.problem.name}: {self.status}, objective {self.objective:.6g}>"


def solve(problem: Union[Source, Problem], *, robot: Union[str, "os.PathLike[str]", None] = None,
          override: Optional[Mapping[str, Any]] = None, seed: Optional[int] = None,
          starts: Optional[int] = None, jobs: int = 1, terms: Union[Term, Iterable[Term]] = (),
          progress: Optional[Progress] = None) -> Plan:
    """Solves a problem by direct collocation (compressed Hermite-Simpson, Ipopt), refines its mesh
    where it asks for that, and verifies the plan by an independent integration.

    Args:
        problem, robot, override: see `load_problem`.
        seed: of everything random, in place of the problem's.
        starts: number of starts, in place of the problem's: its guess, then smooth random ones.
        jobs: processes at a time where there are several starts.
        terms: constraints and costs of your own, that the problem names by their `type`; slow, and with
            one start alone, for several run in processes without Python.
        progress: called after every iteration with its number, the objective and the largest
            violation of a row; not from within several starts. What it raises ends the solve. True:
            a bar of tqdm.

    Returns:
        A `Plan`. One that did not converge says so by `status` and `converged`.

    Raises:
        InputError: with file, line and key.
        Interrupted: Ctrl-C; `result` is the plan at the last iterate, or of several starts the best of
            those that had ended.

    Source: Norby, Li, Selby, Patel and Johnson, Enabling Dynamic Behaviors with Aerodynamic Drag in
    Lightweight Tails, T-RO 2021.
    """
    seed, starts = whole_or_none("seed", seed, 0), whole_or_none("starts", starts, 1, 10000)
    jobs = whole("jobs", jobs, 1, 1024)
    loaded = load_problem(problem, robot=robot, override=override, terms=terms)
    if loaded._has_own_terms and (starts or loaded.to_dict()["solver"]["starts"]) > 1:
        raise InputError.of("starts", "more than one given; allowed: 1 with terms in Python")
    with shown(progress, loaded.name, show_iteration, "iteration") as call:
        plan = Plan(_core.solve(loaded._core, seed, starts, jobs, call))
    if plan._core.interrupted:
        kept = "the last iterate" if plan.status == "interrupted" else "the best plan until then"
        raise Interrupted(f"{loaded.name}: interrupted; result has {kept}", plan)
    return plan


class Comparison:
    """Plans side by side; the first one is what the others are measured against.

    Attributes:
        plans: the `Plan`s, in the order given.
    """

    def __init__(self, plans: list[Plan]):
        self.plans = plans

    @property
    def _cores(self) -> list[_core.Plan]:
        return [plan._core for plan in self.plans]

    @property
    def summary(self) -> str:
        """What `jaculus compare` prints."""
        return _core.comparison_text(self._cores)

    @property
    def figures(self) -> dict[str, Any]:
        """The content of compare.json."""
        return json.loads(_core.comparison_json(self._cores))

    def save(self, folder: Union[str, "os.PathLike[str]"]) -> Path:
        """Writes what `jaculus compare` writes into its `--out`: compare.csv, compare.json, report.html,
        and a folder a plan by its problem's name.

        Raises:
            InputError: two plans of one name.
        """
        from pathlib import Path
        _core.save_comparison(self._cores, os.fspath(folder))
        return Path(folder)

    def to_pandas(self) -> Any:
        """compare.csv as a pandas.DataFrame, a row a problem; units are in the columns' names."""
        import io
        return pandas().read_csv(io.StringIO(_core.comparison_csv(self._cores)))

    def plot(self, column: str = "x_velocity") -> Any:
        """One column of all plans over time; returns the matplotlib figure."""
        figure, axis = pyplot().subplots(layout="constrained")
        for plan in self.plans:
            axis.plot(plan.time, plan[column], label=plan.problem.name)
        axis.set_xlabel("time [s]")
        axis.set_ylabel(labelled(column, self.plans[0].units[column]))
        axis.legend()
        return figure

    def __repr__(self) -> str:
        return f"<jaculus.Comparison of {len(self.plans)} plans>"

    def _repr_html_(self) -> str:
        return page(_core.comparison_html(self._cores))


Compared = Union[Source, Problem, Plan]


def compare(problems: Union[Compared, Iterable[Compared]], *, seed: Optional[int] = None,
            jobs: int = 1) -> Comparison:
    """Solves several problems, one after the other, and tabulates them against the first.

    Args:
        problems: one or several, as `solve` takes them; a `Plan` is taken as it is.
        seed: of everything random, in place of the problems'.
        jobs: processes at a time where a problem has several starts.

    Raises:
        InputError: before anything is solved.
        Interrupted: Ctrl-C; `result` compares the plans that are done.
    """
    alone = isinstance(problems, (str, os.PathLike, Mapping, Problem, Plan))
    many: Any = [problems] if alone else problems
    given = [p if isinstance(p, Plan) else load_problem(p) for p in many]
    if not given:
        raise InputError.of("problems", "none given; allowed: one or more")
    plans: list[Plan] = []
    for entry in given:
        try:
            plans.append(entry if isinstance(entry, Plan) else solve(entry, seed=seed, jobs=jobs))
        except Interrupted as stop:
            raise Interrupted(f"interrupted; {len(plans)} of {len(given)} problems are solved",
                              Comparison(plans)) from stop
    return Comparison(plans)
