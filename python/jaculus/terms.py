"""Constraints and costs in Python, and the check of a problem's derivatives."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

from . import _core
from ._inputs import compiled_all, quantity

if TYPE_CHECKING:
    from ._derivatives import Evaluate

Place = tuple[str, str]  # ("velocity", "pitch")
BLOCKS = ("position", "velocity", "input", "acceleration")


class Row(NamedTuple):
    """One row of a constraint: lower <= value <= upper, in `unit` (SI); `scale` is its typical size."""
    name: str
    unit: str
    lower: float = -inf
    upper: float = inf
    scale: float = 1.0


class Point:
    """What a term reads of one point of a plan: mappings by name, SI.

    Attributes:
        position, velocity, acceleration: by coordinate, as "x", "pitch", "tail".
        input: by motor, the torque of one at the joint [N m].
    """

    def __init__(self, places: Sequence[Place], numbers: Iterable[Any]):
        blocks: dict[str, dict[str, Any]] = {block: {} for block in BLOCKS}
        for (block, name), number in zip(places, numbers):
            blocks[block][name] = number
        self.position, self.velocity = blocks["position"], blocks["velocity"]
        self.input, self.acceleration = blocks["input"], blocks["acceleration"]


class Term:
    """A constraint or cost, written in Python: problems that are loaded with it know it by name.

        >>> class PitchRate(jaculus.Term):
        ...     name = "pitch_rate"
        ...     meaning = "how fast the body may pitch"
        ...     keys = {"limit": {"unit": "rad/s", "meaning": "largest rate either way"}}
        ...     reads = ("velocity",)
        ...     linear = True
        ...     def rows(self, keys):
        ...         return [jaculus.Row("pitch rate", "rad/s", -keys["limit"], keys["limit"], keys["limit"])]
        ...     def value(self, point, keys):
        ...         return point.velocity["pitch"]
        ...     def jacobian(self, point, keys):
        ...         return {("velocity", "pitch"): 1.0}
        >>> jaculus.solve({..., "constraints": [{"type": "pitch_rate", "limit": "200 deg/s"}]},
        ...               terms=[PitchRate()])

    It holds at every collocation point of its `phases` (all, unless the problem says which); a cost is the
    integral over all phases. This is slow: every point of every iteration calls Python.
    `check_derivatives` compares its derivatives with differences.

    Attributes:
        name: its `type` in a problem.
        meaning: one line.
        cost: whether it is a cost.
        unit: of a cost's value, the integral's.
        keys: numbers that a problem gives, by name: unit (SI), meaning, and default where it may be left out.
        reads: the blocks of the point that it reads, of "position", "velocity", "input", "acceleration".
            Sparsity follows from these.
        derivatives: None: `jacobian` is the user's own; "casadi" or "jax": of `value`, traced once, with
            casadi.sin or jax.numpy.sin in it where it has a sine, without branches.
        linear: no second derivatives.

    Methods:
        rows(keys): the `Row`s of a constraint, at most 32. A cost needs none.
        value(point, keys): a number a row (`Point`; keys as numbers in SI).
        jacobian(point, keys): where `derivatives` is None, d(value) by what it depends on, a dict for each
            row: {("velocity", "pitch"): 2.0}; of one row the dict alone.
        hessian(point, keys, multipliers): the sum over rows of multiplier times second derivatives, a dict
            {(("velocity", "pitch"), ("input", "tail")): ...}, either order of a pair once; where it is
            missing, by differences of the Jacobian, to about 1e-8 of it.
    """

    name: str
    meaning: str
    cost: bool = False
    unit: str = ""
    keys: Mapping[str, Mapping[str, Any]] = {}
    reads: Sequence[str] = ()
    derivatives: Optional[str] = None
    linear: bool = False

    def rows(self, keys: Mapping[str, float]) -> Sequence[Row]:
        if not self.cost:
            raise TypeError(f"{type(self).__name__}: no rows given; allowed: a method `rows`")
        return [Row(self.name, self.unit)]

    def value(self, point: Point, keys: Mapping[str, float]) -> Any:
        raise NotImplementedError(f"{type(self).__name__}.value")

    def jacobian(self, point: Point, keys: Mapping[str, float]) -> Any:
        raise NotImplementedError(f"{type(self).__name__}.jacobian, or derivatives = \"casadi\", \"jax\"")

    hessian: Optional[Callable[..., Mapping[tuple[Place, Place], float]]] = None

    def _compiled(self) -> _core.Term:
        """As the library takes it."""
        unknown = [block for block in self.reads if block not in BLOCKS]
        if unknown or not self.reads:
            raise ValueError(f"{self.name}: reads {unknown or 'nothing'}; allowed: {', '.join(BLOCKS)}")
        keys = [(name, key["unit"], key["meaning"],
                 quantity(key["default"]) if "default" in key else None) for name, key in self.keys.items()]
        return _core.own_term(self.name, self.meaning, self.unit, keys, list(self.reads), self.cost,
                              self.linear, self._make)

    def _make(self, keys: dict[str, float], coordinates: list[str], motors: list[str]) -> tuple[
            list[Row], Evaluate]:
        """The rows for a problem's keys on a robot, and what computes them."""
        from ._derivatives import evaluation
        places = [(block, name) for block in BLOCKS if block in self.reads
                  for name in (motors if block == "input" else coordinates)]
        rows = [Row(*row) for row in self.rows(keys)]
        for name, _, lower, upper, scale in rows:
            if not lower <= upper or not scale > 0.0:
                raise ValueError(f"{self.name}: row {name!r}: bounds [{lower}, {upper}], scale {scale}; "
                                 "allowed: the lower one first, a scale above 0")
        return rows, evaluation(self, places, keys, len(rows))

    def __repr__(self) -> str:
        return f"<jaculus.Term {self.name}: {self.meaning}>"


def compiled(terms: Union[Term, Iterable[Term]]) -> list[_core.Term]:
    """Users' terms as the library takes them."""
    return compiled_all(terms, Term)


class DerivativeCheck:
    """How a problem's derivatives compare with central differences.

    Attributes:
        gradient, jacobian, hessian: the largest disagreement of each: error (relative to 1 + the largest
            entry of the row), analytic, difference, row, column.
        error: the largest of the three [-]; differences themselves are good to about 1e-7.
        summary: a line each.
    """

    def __init__(self, core: _core.DerivativeReport):
        if not core.defined:
            raise ValueError("the problem's functions have no value at this point; allowed: another seed, or a "
                             "smaller spread")
        kinds = ("gradient", "jacobian", "hessian")
        found = {kind: {key: getattr(getattr(core, kind), key)
                        for key in ("error", "analytic", "difference", "row", "column")} for kind in kinds}
        self.gradient: dict[str, Any] = found["gradient"]
        self.jacobian: dict[str, Any] = found["jacobian"]
        self.hessian: dict[str, Any] = found["hessian"]
        self.error: float = max(of["error"] for of in found.values())
        self.summary: str = "\n".join(
            f"{kind}: {of['error']:.1e} at most, of {of['row']} by {of['column']}: {of['analytic']:.8g} where "
            f"differences give {of['difference']:.8g}" for kind, of in found.items())

    def __repr__(self) -> str:
        return f"<jaculus.DerivativeCheck: error {self.error:.1e}>"
