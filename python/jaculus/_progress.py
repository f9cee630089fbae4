"""Progress by a callback of the user's, or by tqdm's bars."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Optional, Union

Progress = Union[bool, Callable[..., None], None]


def _bar(**options: Any) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError as missing:
        raise ImportError("progress=True needs tqdm: pip install tqdm") from missing
    return tqdm(**options)


@contextmanager
def shown(progress: Progress, title: str, show: Callable[..., None], unit: str) -> Iterator[
        Optional[Callable[..., None]]]:
    """What is called with each step: the user's own, or one that shows it by `show(bar, ...)`."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with _bar(desc=title, unit=unit) as bar:
            yield lambda *step: show(bar, *step)
    else:
        yield progress


def show_iteration(bar: Any, iteration: int, objective: float, violation: float) -> None:
    bar.set_postfix(objective=f"{objective:.6g}", violation=f"{violation:.1e}", refresh=False)
    bar.update()


def show_point(bar: Any, done: int, points: int) -> None:
    bar.total = points
    bar.update(done - bar.n)


def show_stage(bar: Any, stage: str) -> None:
    bar.set_postfix_str(stage, refresh=False)
    bar.update()
