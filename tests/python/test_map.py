"""jaculus.map: the same results, in order, whatever runs the items."""
import concurrent.futures
import os

import pytest

import jaculus


def doubled(item):
    if item == 13:
        raise ValueError("thirteen is refused")
    return 2 * item


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    """Jobs of submitit import this module."""
    folder = os.path.dirname(os.path.abspath(__file__))
    paths = [folder, *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))


ITEMS = [3, 1, 2, 2, 7]


def test_items_run_here_unless_told():
    assert jaculus.map(doubled, iter(ITEMS)) == [6, 2, 4, 4, 14]


def test_what_has_a_map_is_an_executor():
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        assert jaculus.map(doubled, ITEMS, executor=pool) == [6, 2, 4, 4, 14]


@pytest.mark.parametrize("chunk", [1, 2, 50])
def test_submitit_runs_the_items(tmp_path, chunk):
    submitit = pytest.importorskip("submitit")
    executor = submitit.LocalExecutor(tmp_path)
    assert jaculus.map(doubled, ITEMS, executor=executor, chunk=chunk) == [6, 2, 4, 4, 14]
    assert len(list(tmp_path.glob("*_submitted.pkl"))) == -(-len(ITEMS) // chunk)


def test_dask_runs_the_items():
    distributed = pytest.importorskip("distributed")
    with distributed.Client(n_workers=1, threads_per_worker=1, dashboard_address=None) as client:
        assert jaculus.map(doubled, ITEMS, executor=client) == [6, 2, 4, 4, 14]


@pytest.mark.parametrize("engine", ["local", "processes", "submitit"])
def test_a_failed_item_leaves_the_others(tmp_path, engine):
    if engine == "local":
        executor = engine
    elif engine == "processes":
        executor = concurrent.futures.ProcessPoolExecutor(1)
    else:
        executor = pytest.importorskip("submitit").LocalExecutor(tmp_path)
    results = jaculus.map(doubled, [1, 13, 2], executor=executor, failures="return")
    assert results[0] == 2 and results[2] == 4
    assert str(results[1]) == "ValueError: thirteen is refused"
    with pytest.raises(RuntimeError, match="1 of 3 items failed.*item 1: ValueError: thirteen is refused"):
        jaculus.map(doubled, [1, 13, 2], executor=executor)


def test_a_preempted_chunk_goes_on_behind_what_is_finished():
    pytest.importorskip("submitit")
    from jaculus.executors import _Chunk
    ran = []
    chunk = _Chunk(ran.append, ITEMS)
    chunk.results = [None, None]
    again = chunk.checkpoint().function
    assert again() == [None] * len(ITEMS)
    assert ran == ITEMS[2:]


@pytest.mark.parametrize("wrong, message", [
    ({"executor": "sllurm"}, "allowed: \"local\", \"slurm\""),
    ({"executor": "local", "timeout_min": 5}, "timeout_min: given"),
    ({"chunk": 0}, "1 or more"),
    ({"failures": "ignore"}, "\"raise\", \"return\""),
])
def test_wrong_arguments_are_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        jaculus.map(doubled, ITEMS, **wrong)
