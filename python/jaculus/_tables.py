"""Tables for people: pandas, and pages in notebooks."""
from __future__ import annotations

from typing import Any


def pandas() -> Any:
    """The module, or an ImportError that says what to install."""
    try:
        import pandas
    except ImportError as missing:
        raise ImportError("to_pandas() needs pandas: pip install pandas") from missing
    return pandas


def pyplot() -> Any:
    try:
        import matplotlib.pyplot
    except ImportError as missing:
        raise ImportError("plot() needs matplotlib: pip install matplotlib") from missing
    return matplotlib.pyplot


def xarray() -> Any:
    try:
        import xarray
    except ImportError as missing:
        raise ImportError("to_xarray() needs xarray: pip install xarray") from missing
    return xarray


def labelled(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def page(document: str, height: int = 720) -> str:
    """A report as a frame of its own within a notebook."""
    import html
    return (f'<iframe srcdoc="{html.escape(document)}" width="100%" height="{height}" '
            'style="border:0"></iframe>')
