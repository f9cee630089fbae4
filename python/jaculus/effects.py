"""Effects of users: in Python, or in files; and checks of both."""
from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional, Union

from . import _core
from ._inputs import Source, compiled_all, node_of
from ._tables import pandas

# Values that an action has, and whether it comes before the motors.
_ACTIONS = {"torque": (1, False), "force": (1, False), "moment": (1, False),
            "torque_scale": (1, True), "bus_drop": (1, True), "friction_scale": (1, True)}


class Effect:
    """An effect that the robot's model lacks, written in Python: `simulate` plays it, `diagnose` and
    `preflight` judge it beside the catalogue's, `check_effect` tries it.

        >>> class Cable(jaculus.Effect):
        ...     name = "elbow_cable"
        ...     caption = "a cable through the elbow pulls towards where it lies straight"
        ...     at = {"joint": "elbow"}
        ...     parameters = {"stiffness": {"unit": "N m/rad", "nominal": 0, "bounds": [0, 2], "scale": 0.05}}
        ...     def torque(self, q, stiffness):
        ...         return -stiffness * q
        >>> jaculus.diagnose(trials, own_effects=[Cable()])

    It has what a file of an effect has (docs/commands.md, "Effects of your own"), with methods in place
    of formulas. This is slow: every step of every simulation calls Python, one thread at a time, so a
    diagnosis takes many times as long as with the same formulas in a file, which it finds alike.

    Attributes:
        name: lower-case letters, digits and _; not one of the catalogue's.
        caption: one line.
        at: where it acts: {"joint": "elbow"}, {"joints": [...]}, {"group": "tail" | "legs" | "other"},
            {"body": "base", "point": [x, z]} [m], {"point": NAME}, {"part": "ground" | "battery"}.
        parameters: by name: unit (SI), nominal, bounds, scale (of the prior), and probe where one scale
            shows too little. At nominal values the effect does nothing; the first one switches it on.
        states: by name: unit, initial (a number or a formula of parameters), scale (typical size).
        component: where shares of the gap count it, where `at` does not say.
        reads: names of arguments that stand for readings of other joints and bodies:
            {"elbow_rate": "elbow.qd", "foot_height": "toe.z"}.

    Methods, each where it has a meaning at the place: `torque` (at a joint that turns) [N m], `force` (at
    a joint that slides [N]; on a body or point (x, z), world frame [N]), `moment` (on a body, about +y)
    [N m], `torque_scale` (share of the motor's torque that arrives) [-], `bus_drop` (what the battery
    lacks) [V], `friction_scale` (of the ground) [-]. With states, `rates` gives the rate of each, in
    their order [unit/s]; of one state a number. Their arguments, by name: readings (q, qd, load, tau,
    current, voltage of the joint; x, z, vx, vz, angle, omega of the body or point; t, bus; SI), those of
    `reads`, parameters, states. Values must follow from the arguments alone: a method is called at times
    that go back and forth, in threads.
    """

    name: str
    caption: str
    at: Mapping[str, Any]
    parameters: Mapping[str, Mapping[str, Any]]
    states: Mapping[str, Mapping[str, Any]] = {}
    component: Optional[str] = None
    reads: Mapping[str, str] = {}

    def _node(self) -> _core.Node:
        declared = {"format": "jaculus-effect/1"}
        for key in ("name", "caption", "at", "component", "parameters", "states"):
            value = getattr(self, key, None)
            if value:
                declared[key] = value
        return node_of(declared)

    def _values(self, action: str) -> int:
        on_body = "body" in self.at or "point" in self.at
        return 2 if action == "force" and on_body else _ACTIONS[action][0]

    def _method(self, name: str) -> tuple[Callable[..., Any], list[str]]:
        """A method and the names of its arguments."""
        method = getattr(self, name)
        arguments = inspect.signature(method).parameters.values()
        for argument in arguments:
            if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD, argument.KEYWORD_ONLY):
                raise TypeError(f"{type(self).__name__}.{name}: {argument} given; allowed: arguments by the "
                                "names of readings, parameters and states")
        return method, [argument.name for argument in arguments]

    def _compiled(self) -> _core.Effect:
        """As the library takes it."""
        actions = [action for action in _ACTIONS if getattr(self, action, None) is not None]
        used = actions + (["rates"] if self.states else [])
        methods = {name: self._method(name) for name in used}
        reads: list[str] = []  # of the library, in the order in which the law gets them
        for _, arguments in methods.values():
            for argument in arguments:
                reading = self.reads.get(argument, argument)
                known = argument in self.parameters or argument in self.states or reading in reads
                if not known:
                    reads.append(reading)

        places: dict[str, list[int]] = {}
        for action in actions:
            first = sum(len(of) for of in places.values())
            places[action] = list(range(first, first + self._values(action)))
        early = [action for action in actions if _ACTIONS[action][1]]
        late = [action for action in actions if not _ACTIONS[action][1]]

        def law(theta: Sequence[float]) -> tuple[Callable[..., list[float]], Callable[..., list[float]]]:
            parts = {name: self._part(name, methods[name], reads, theta) for name in used}
            before = _joined([parts[action] for action in early])
            after = _joined([parts[name] for name in late + (["rates"] if self.states else [])])
            return before, after

        return _core.coded_effect(self._node(), reads, actions, [at for a in early for at in places[a]],
                                  [at for a in late for at in places[a]], len(self.states), law)

    def _part(self, name: str, of: tuple[Callable[..., Any], list[str]], reads: list[str],
              theta: Sequence[float]) -> Callable[..., list[float]]:
        """A method as a function of all readings and states, at parameters."""
        method, arguments = of
        numbers = reads + list(self.states)
        values = dict(zip(self.parameters, theta))
        given = [(None, values[argument]) if argument in values
                 else (numbers.index(argument if argument in self.states
                                     else self.reads.get(argument, argument)), 0.0)
                 for argument in arguments]
        count = len(self.states) if name == "rates" else self._values(name)

        def part(*numbers: float) -> list[float]:
            told = method(*[value if at is None else numbers[at] for at, value in given])
            told = [float(told)] if count == 1 and not isinstance(told, Sequence) else [float(v) for v in told]
            if len(told) != count:
                raise ValueError(f"{type(self).__name__}.{name} gave {len(told)} values; allowed: {count}")
            return told
        return part

    def __repr__(self) -> str:
        return f"<jaculus.Effect {self.name}: {self.caption}>"


def _joined(parts: list[Callable[..., list[float]]]) -> Callable[..., list[float]]:
    """All their values, one after the other."""
    if len(parts) == 1:
        return parts[0]
    return lambda *numbers: [value for part in parts for value in part(*numbers)]


def compiled(own_effects: Union[Effect, Iterable[Effect]]) -> list[_core.Effect]:
    """Users' effects as the library takes them."""
    return compiled_all(own_effects, Effect)


class EffectChecks:
    """What was tried of an effect.

    Attributes:
        passed: whether all of it holds.
        checks: a dict each: what, found, passed.
        summary: a line each.
    """

    def __init__(self, checks: list[_core.Check]):
        self.checks = [{"what": c.what, "found": c.found, "passed": c.passed} for c in checks]
        self.passed: bool = all(check["passed"] for check in self.checks)
        self.summary: str = "\n".join(
            f"{'ok' if c['passed'] else 'FAILED':6}  {c['what']}: {c['found']}" for c in self.checks)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row a check."""
        return pandas().DataFrame(self.checks)

    def __repr__(self) -> str:
        failed = sum(not check["passed"] for check in self.checks)
        return f"<jaculus.EffectChecks: {len(self.checks)} checks, {failed} failed>"


def check_effect(effect: Union[Effect, str, "os.PathLike[str]"],
                 experiment: Optional[Source] = None) -> EffectChecks:
    """Tries an effect in an experiment, as `jaculus check my_effect.yaml` does: nominal changes nothing,
    bit for bit; its influence fades smoothly to nothing; simulated data give the first parameter back,
    without noise and with; every other parameter matters beside it.

    Args:
        effect: of Python, or the YAML file of one.
        experiment: a YAML file, the name of one that comes with jaculus, or a dict, that shows the
            effect; a file may name its own.

    Raises:
        InputError: with file, line and key; where the experiment's robot can't have the effect.
    """
    if isinstance(effect, Effect):
        core = effect._compiled()
    else:
        core = _core.read_effect(os.fspath(effect))
        if experiment is None and str(core.experiment) not in ("", "."):
            experiment = core.experiment
    if experiment is None:
        raise ValueError(f"{core.name}: no experiment to try it in; allowed: experiment=...")
    return EffectChecks(_core.check_effect(core, _core.load_experiment(node_of(experiment))))
