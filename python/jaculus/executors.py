"""One function of many items, on the engines that laboratories have: submitit for Slurm, Dask, Ray."""
from __future__ import annotations

import os
from typing import Any, Callable, Iterable, Literal, Union

_MOST_JOBS = 1000  # of one array; Slurm's MaxArraySize is 1001 unless a site changes it


class _Failure:
    """Why an item has no result. Exceptions themselves need not survive the way back."""

    def __init__(self, error: BaseException):
        self.text = f"{type(error).__name__}: {error}"


def _attempt(function: Callable[[Any], Any], item: Any) -> Any:
    try:
        return function(item)
    except Exception as error:  # whatever it is, other items go on
        return _Failure(error)


class _Attempt:
    """`_attempt` with its function, as engines take it."""

    def __init__(self, function: Callable[[Any], Any]):
        self.function = function

    def __call__(self, item: Any) -> Any:
        return _attempt(self.function, item)


class _Chunk:
    """Items of one job. Preempted or out of time, submitit has it go on behind what is finished."""

    def __init__(self, function: Callable[[Any], Any], items: list[Any]):
        self.function, self.items = function, items
        self.results: list[Any] = []

    def __call__(self) -> list[Any]:
        for item in self.items[len(self.results):]:
            self.results.append(_attempt(self.function, item))
        return self.results

    def checkpoint(self) -> Any:
        from submitit.helpers import DelayedSubmission
        return DelayedSubmission(self)


def _slurm(folder: Union[str, "os.PathLike[str]"], options: dict[str, Any]) -> Any:
    try:
        import submitit
    except ImportError as missing:
        raise ImportError('executor="slurm" needs submitit: pip install submitit') from missing
    executor = submitit.AutoExecutor(folder=os.fspath(folder), cluster="slurm")
    executor.update_parameters(name="jaculus", **options)
    return executor


def _by_submitit(executor: Any, function: Callable[[Any], Any], items: list[Any], chunk: int) -> list[Any]:
    size = max(chunk, -(-len(items) // _MOST_JOBS))
    chunks = [_Chunk(function, items[first:first + size]) for first in range(0, len(items), size)]
    with executor.batch():  # one array
        jobs = [executor.submit(part) for part in chunks]
    results: list[Any] = []
    for job, part in zip(jobs, chunks):
        try:
            results += job.result()
        except Exception as error:  # the job itself was lost
            results += [_Failure(error)] * len(part.items)
    return results


def map(function: Callable[[Any], Any], items: Iterable[Any], *, executor: Any = "local",
        folder: Union[str, "os.PathLike[str]"] = "jaculus_jobs", chunk: int = 1,
        failures: Literal["raise", "return"] = "raise", **options: Any) -> list[Any]:
    """`[function(item) for item in items]`, on a cluster.

    Args:
        function: of one item. What it takes and returns is pickled: numbers, arrays, dicts (`plan.figures`),
            not a `Plan`.
        items: in whose order results come.
        executor: "local": here, one after the other. "slurm": jobs of submitit, an array of them. An
            executor of submitit, one of concurrent.futures, a `dask.distributed.Client`, a
            `ray.util.multiprocessing.Pool`, or anything else with a `map(function, items)`.
        folder: for "slurm": of submitit's files, on a disk that all machines share.
        chunk: items of a job, for "slurm" and submitit; more where there would be over 1000 jobs.
        failures: "raise": RuntimeError after the last item, with the first failed one's reason. "return":
            that stands in the item's place, a RuntimeError.
        options: for "slurm": parameters of submitit, as `timeout_min=60, slurm_partition="short"`.

    Raises:
        RuntimeError: an item failed.
        ValueError: the executor is none of these.
        ImportError: submitit is not installed.
    """
    items = list(items)
    if options and not (isinstance(executor, str) and executor == "slurm"):
        raise ValueError(f'{", ".join(options)}: given; allowed: with executor="slurm"')
    if failures not in ("raise", "return"):
        raise ValueError(f'failures={failures!r}; allowed: "raise", "return"')
    if chunk < 1:
        raise ValueError(f"chunk={chunk}; allowed: 1 or more")
    if isinstance(executor, str) and executor == "slurm":
        executor = _slurm(folder, options)

    if isinstance(executor, str) and executor == "local":
        results = [_attempt(function, item) for item in items]
    elif hasattr(executor, "map_array"):
        results = _by_submitit(executor, function, items, chunk)
    elif hasattr(executor, "gather"):  # Dask; an item may stand there twice, a task may be random
        results = executor.gather(executor.map(_Attempt(function), items, pure=False))
    elif hasattr(executor, "map"):
        results = list(executor.map(_Attempt(function), items))
    else:
        raise ValueError(f'executor={executor!r}; allowed: "local", "slurm", an object with a map(function, items)')
    return _checked(results, failures)


def _checked(results: list[Any], failures: str) -> list[Any]:
    failed = [k for k, result in enumerate(results) if isinstance(result, _Failure)]
    if failed and failures == "raise":
        raise RuntimeError(f"{len(failed)} of {len(results)} items failed, the first being item {failed[0]}: "
                           f"{results[failed[0]].text}")
    return [RuntimeError(result.text) if isinstance(result, _Failure) else result for result in results]
