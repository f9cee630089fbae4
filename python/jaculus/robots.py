"""Robots and problems: what a solve starts from."""
from __future__ import annotations

import json
import os
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Optional, Union

from . import _core
from ._errors import InputError
from ._inputs import Source, node_of, whole
from .terms import DerivativeCheck, Term, compiled

if TYPE_CHECKING:
    from pathlib import Path


class Robot:
    """A robot as read from its folder, reduced to the sagittal plane.

    Attributes:
        name: of the robot.
        folder: with robot.urdf and robot.yaml.
        mass: of all of it [kg].
        coordinates: names of the generalised coordinates; x, z [m] and pitch [rad] of the base where
            they are free, then joints [rad or m].
        motors: names of the joints that have a motor.
        feet: names of the feet.
        notes: what was merged, dropped or assumed on the way, a sentence each.
        summary: all this as text.
        imported: of `import_robot`, what it decided, assumed, held, dropped, and what is to fill in.
    """

    def __init__(self, core: _core.Robot):
        self._core = core
        self.name: str = core.name
        self.mass: float = core.mass
        self.coordinates: list[str] = core.coordinates
        self.motors: list[str] = core.motors
        self.feet: list[str] = core.feet
        self.notes: list[str] = core.notes
        self.imported: dict[str, Any] = {}

    @cached_property
    def folder(self) -> Path:
        return self._core.folder

    @cached_property
    def summary(self) -> str:
        return self._core.summary

    @property
    def values(self) -> dict[str, str]:
        """Values that `override` may replace, by path, as text with units."""
        return dict(line.split(" = ", 1) for line in self._core.override_paths)

    def __repr__(self) -> str:
        return f"<jaculus.Robot {self.name}: {self.mass:.4g} kg, {len(self.motors)} motors>"


class Problem:
    """A problem, checked against its robot, ready to be solved.

    Attributes:
        name: of the problem, which names its folder of results.
        caption: a line on it.
        robot: the `Robot`, overrides applied.
        summary: what was understood, as text.
    """

    def __init__(self, core: _core.Problem, has_own_terms: bool = False):
        self._core = core
        self._has_own_terms = has_own_terms
        self.name: str = core.name
        self.caption: str = core.caption
        self.robot = Robot(core.robot)

    @cached_property
    def summary(self) -> str:
        return self._core.summary

    def to_dict(self) -> dict[str, Any]:
        """Every key of the problem with its value, defaults spelt out, SI."""
        return json.loads(self._core.json)

    def __repr__(self) -> str:
        return f"<jaculus.Problem {self.name} of {self.robot.name}>"


def load_robot(robot: Union[str, "os.PathLike[str]"]) -> Robot:
    """Reads a robot.

    Args:
        robot: a folder with robot.urdf (and robot.yaml), or the name of one that comes with jaculus
            ("minitaur_tail"). Folders of the environment variable JACULUS_MODELS are looked at first.

    Raises:
        InputError: no such robot, or a fault in its files.
    """
    return Robot(_core.load_robot(os.fspath(robot)))


def import_robot(file: Union[str, "os.PathLike[str]"], out: Union[str, "os.PathLike[str]"], *,
                 tail: str = "", pose: Optional[Mapping[str, float]] = None, replace: bool = False,
                 options: Iterable[str] = ()) -> Robot:
    """Makes a robot of a file of others, as `jaculus robot import` does: a folder with robot.urdf, a
    commented robot.yaml, a first experiment (stand.yaml, swing.yaml or fall.yaml) and, where it has
    front and rear legs, a first leap, leap.yaml.

    Args:
        file: URDF, MJCF, or xacro where ROS's tool is there.
        out: the robot's folder, written.
        tail: mass of a drag tail to add, "10 %" of the robot's or "1.2 kg".
        pose: of joints that are held, or of the pose at rest, by their names in the file [rad or m].
        replace: write over a robot that is there.
        options: others of the command, as ["--base", "fixed", "--strict"].

    Raises:
        InputError: with the file and what is allowed; its line where the fault is in one.
    """
    import subprocess
    from ._command import program
    folder = os.path.abspath(out)
    command = [os.fspath(program()), "robot", "import", os.fspath(file), "--out", folder, "--json"]
    command += [*options, *(["--tail", tail] if tail else [])]
    for joint, value in (pose or {}).items():
        command += ["--pose", f"{joint}={float(value)!r}"]
    command += ["--replace"] if replace else []
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 2:
        raise InputError.told(done.stderr.strip().removeprefix("jaculus: "), file)
    if done.returncode != 0:
        raise RuntimeError(f"jaculus robot import ended with {done.returncode}: {done.stderr.strip()}")
    robot = load_robot(folder)
    robot.imported = json.loads(done.stdout)
    return robot


def load_problem(problem: Union[Source, Problem], *, robot: Union[str, "os.PathLike[str]", None] = None,
                 override: Optional[Mapping[str, Any]] = None,
                 terms: Union[Term, Iterable[Term]] = ()) -> Problem:
    """Reads a problem and checks it against its robot, as `jaculus check` does.

    Args:
        problem: a YAML file; the name of one that comes with jaculus ("leap_tail", see `shipped`); or
            a dict with the keys of such a file, where `extends` may name another. Paths within a dict
            are relative to the working directory. Numbers are SI (rad, not degrees); a text may state
            its unit, "16 V".
        robot: a folder or name, in place of the problem's.
        override: model values over the problem's, by path: {"tail.drag.coefficient": 1.5}.
            `Robot.values` has the paths.
        terms: constraints and costs of your own, that the problem names by their `type`.

    Raises:
        InputError: with file, line and key.
    """
    own = compiled(terms)
    if isinstance(problem, Problem):
        if robot is None and not override and not own:
            return problem
        raise TypeError("robot, override and terms are for a file or a dict; a Problem is loaded already")
    if isinstance(problem, Mapping):
        changed = dict(problem)
    elif robot is None and not override:
        return Problem(_core.load_problem(node_of(problem), own), bool(own))
    else:
        file = os.path.abspath(_core.find_problem_file(os.fspath(problem)))
        name = _core.load_problem(_core.Node.load(file), own).name
        changed = {"format": "jaculus-problem/1", "extends": file, "name": name}
    if robot is not None:
        changed["robot"] = os.fspath(robot)
    if override:
        changed["override"] = {**changed.get("override", {}), **override}
    return Problem(_core.load_problem(node_of(changed), own), bool(own))


def check_derivatives(problem: Union[Source, Problem], *, terms: Union[Term, Iterable[Term]] = (),
                      seed: int = 1, spread: float = 0.05) -> DerivativeCheck:
    """Compares a problem's gradient, Jacobian and Hessian with central differences, entry by entry, what
    sparsity leaves out included, at a random point about the problem's guess.

    Args:
        problem, terms: see `load_problem`.
        seed: of the point and of the multipliers that the Hessian is taken with.
        spread: of the point about the guess [scales of the variables].

    Raises:
        InputError: with file, line and key.
        ValueError: no value there.
    """
    seed = whole("seed", seed, 0)
    if not 0.0 <= spread < inf:
        raise InputError.of("spread", f"{spread} given; allowed: 0 or more")
    loaded = load_problem(problem, terms=terms)
    return DerivativeCheck(_core.check_derivatives(loaded._core, seed, spread))


def shipped(kind: str = "problems") -> list[str]:
    """Names of what comes with jaculus.

    Args:
        kind: "problems" (experiments and studies among them), "models" or "effects".
    """
    if kind not in ("problems", "models", "effects"):
        raise ValueError(f"kind: {kind!r} given; allowed: problems, models, effects")
    from pathlib import Path
    found = set()
    for folder in _core.data_folders():
        for path in (Path(folder) / kind).glob("*"):
            if path.suffix == ".yaml" or (kind == "models" and path.is_dir()):
                found.add(path.stem)
    return sorted(found)
