"""What users give, as the library takes it: files, names, dicts."""
from __future__ import annotations

import json
import operator
import os
from collections.abc import Mapping
from typing import Any, Optional, Union

from . import _core
from ._errors import InputError

Source = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def plain(value: Any) -> Any:
    """A value of a dict that JSON doesn't know: NumPy's numbers and arrays, paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} in a dict of input; allowed: what YAML holds")


def node_of(source: Source) -> _core.Node:
    """The YAML document of a file, of a name that comes with jaculus, or of a dict."""
    if isinstance(source, Mapping):
        # JSON is YAML. Paths in it are relative to the working directory.
        return _core.Node.parse(json.dumps(source, indent=1, ensure_ascii=False, default=plain), "dict")
    return _core.Node.load(_core.find_problem_file(os.fspath(source)))


def compiled_all(given: Any, kind: type) -> list[Any]:
    """Users' objects of one class, or one alone, as the library takes them."""
    many: list[Any] = [given] if isinstance(given, kind) else list(given)
    for own in many:
        if not isinstance(own, kind):
            raise TypeError(f"{own!r} given; allowed: objects of a class that is a jaculus.{kind.__name__}")
    return [own._compiled() for own in many]


def whole(name: str, value: Any, least: int, most: int = 2**31 - 1) -> int:
    """A whole number as the command takes it."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or not least <= value <= most:
        raise InputError.of(name, f"{value!r} given; allowed: {least} to {most}")
    return operator.index(value)


def whole_or_none(name: str, value: Any, least: int, most: int = 2**31 - 1) -> Optional[int]:
    return None if value is None else whole(name, value, least, most)


def quantity(value: Union[str, float], unit: str = "") -> str:
    """A number, in SI, or a text with its unit."""
    return value if isinstance(value, str) else f"{float(value)!r} {unit}".rstrip()
