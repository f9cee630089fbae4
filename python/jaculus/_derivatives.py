"""Values and derivatives of a user's term as flat lists, whoever differentiates them."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from .terms import Place, Term

# (numbers, whether the Jacobian is asked for, multipliers or None) to values, Jacobian by rows, Hessian.
Flat = Optional[list[float]]
Evaluate = Callable[[list[float], bool, Optional[list[float]]], tuple[list[float], Flat, Flat]]

STEP = 6e-6  # of differences, relative: the cube root of the rounding


def evaluation(term: Term, places: Sequence[Place], keys: Mapping[str, float], rows: int) -> Evaluate:
    """What the library calls for a term whose point has these places."""
    makers = {None: _own, "casadi": _by_casadi, "jax": _by_jax}
    if term.derivatives not in makers:
        raise ValueError(f"{term.name}: derivatives = {term.derivatives!r}; allowed: None, \"casadi\", \"jax\"")
    return makers[term.derivatives](term, places, keys, rows)


def _parts(term: Term, method: str, told: Any, rows: int) -> list[Any]:
    """What a method gives, a part a row."""
    parts = list(told) if isinstance(told, (Sequence, np.ndarray)) else [told]
    if len(parts) != rows:
        raise ValueError(f"{term.name}: {method} gave {len(parts)} rows; allowed: {rows}")
    return parts


def _own(term: Term, places: Sequence[Place], keys: Mapping[str, float], rows: int) -> Evaluate:
    from .terms import Point
    index = {place: i for i, place in enumerate(places)}

    def column(place: Place) -> int:
        if place not in index:
            raise KeyError(f"{term.name}: {place} is not read; allowed: {', '.join(map(str, places))}")
        return index[place]

    def jacobian(numbers: Sequence[float]) -> np.ndarray:
        matrix = np.zeros((rows, len(places)))
        told = _parts(term, "jacobian", term.jacobian(Point(places, numbers), keys), rows)
        for r, entries in enumerate(told):
            for place, value in entries.items():
                matrix[r, column(place)] = value
        return matrix

    def hessian(numbers: Sequence[float], multipliers: Sequence[float]) -> np.ndarray:
        matrix = np.zeros((len(places), len(places)))
        if term.linear:
            return matrix
        if term.hessian is None:
            return _by_differences(jacobian, numbers, multipliers)
        for (a, b), value in term.hessian(Point(places, numbers), keys, multipliers).items():
            i, j = column(a), column(b)
            matrix[i, j] = matrix[j, i] = value
        return matrix

    def evaluate(numbers: list[float], wanted: bool, multipliers: Optional[list[float]]) -> tuple[
            list[float], Flat, Flat]:
        values = _parts(term, "value", term.value(Point(places, numbers), keys), rows)
        return ([float(v) for v in values], jacobian(numbers).ravel().tolist() if wanted else None,
                None if multipliers is None else hessian(numbers, multipliers).ravel().tolist())
    return evaluate


def _by_differences(jacobian: Callable[[Sequence[float]], np.ndarray], numbers: Sequence[float],
                    multipliers: Sequence[float]) -> np.ndarray:
    """The multipliers' Hessian by central differences of the Jacobian, made symmetric."""
    matrix = np.zeros((len(numbers), len(numbers)))
    for i, number in enumerate(numbers):
        step = STEP * (1.0 + abs(number))
        moved = [list(numbers), list(numbers)]
        moved[0][i] += step
        moved[1][i] -= step
        width = moved[0][i] - moved[1][i]
        matrix[i] = np.asarray(multipliers) @ (jacobian(moved[0]) - jacobian(moved[1])) / width
    return 0.5 * (matrix + matrix.T)


def _by_casadi(term: Term, places: Sequence[Place], keys: Mapping[str, float], rows: int) -> Evaluate:
    try:
        import casadi
    except ImportError as missing:
        raise ImportError(f"{term.name}: derivatives = \"casadi\" needs casadi: pip install casadi") from missing
    from .terms import Point
    symbols, weights = casadi.SX.sym("point", len(places)), casadi.SX.sym("multipliers", rows)
    told = term.value(Point(places, casadi.vertsplit(symbols)), keys)
    value = casadi.vertcat(*told) if isinstance(told, Sequence) else casadi.vertcat(told)
    if value.shape != (rows, 1):
        raise ValueError(f"{term.name}: value gave {value.shape[0]} rows; allowed: {rows}")
    jacobian = casadi.densify(casadi.jacobian(value, symbols))
    hessian = casadi.densify(casadi.hessian(casadi.dot(weights, value), symbols)[0])
    functions = [casadi.Function(name, given, [casadi.densify(what)]) for name, given, what in (
        ("value", [symbols], value), ("jacobian", [symbols], jacobian.T),  # columns come first in a DM
        ("hessian", [symbols, weights], hessian))]

    def evaluate(numbers: list[float], wanted: bool, multipliers: Optional[list[float]]) -> tuple[
            list[float], Flat, Flat]:
        return (functions[0](numbers).nonzeros(), functions[1](numbers).nonzeros() if wanted else None,
                None if multipliers is None else functions[2](numbers, multipliers).nonzeros())
    return evaluate


def _by_jax(term: Term, places: Sequence[Place], keys: Mapping[str, float], rows: int) -> Evaluate:
    try:
        import jax
        import jax.experimental
    except ImportError as missing:
        raise ImportError(f"{term.name}: derivatives = \"jax\" needs jax: pip install jax") from missing
    from .terms import Point
    # JAX computes in 32 bits otherwise. The name is that of newer versions, or of older ones.
    experimental: Any = jax.experimental
    double = partial(jax.enable_x64, True) if hasattr(jax, "enable_x64") else experimental.enable_x64

    def value(numbers: Any) -> Any:
        told = term.value(Point(places, [numbers[i] for i in range(len(places))]), keys)
        parts = [told] if getattr(told, "ndim", 1) == 0 else told
        return jax.numpy.stack(_parts(term, "value", [jax.numpy.asarray(part) for part in parts], rows))

    functions = (jax.jit(value), jax.jit(jax.jacfwd(value)),
                 jax.jit(jax.hessian(lambda numbers, weights: weights @ value(numbers))))

    def evaluate(numbers: list[float], wanted: bool, multipliers: Optional[list[float]]) -> tuple[
            list[float], Flat, Flat]:
        with double():
            point = np.asarray(numbers)
            return (_flat(functions[0](point)), _flat(functions[1](point)) if wanted else None,
                    None if multipliers is None else _flat(functions[2](point, np.asarray(multipliers))))
    return evaluate


def _flat(array: Any) -> list[float]:
    return np.asarray(array, dtype=float).ravel().tolist()
