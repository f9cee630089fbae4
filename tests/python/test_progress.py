import io

import pytest

import jaculus
from jaculus import _progress


def shown_by(monkeypatch, work):
    """What tqdm's bars show."""
    tqdm = pytest.importorskip("tqdm", reason="bars need tqdm")
    text = io.StringIO()
    monkeypatch.setattr(
        _progress, "_bar", lambda **options: tqdm.tqdm(file=text, mininterval=0.0, **options)
    )
    work()
    return text.getvalue()


def test_a_solve_shows_its_iterations(monkeypatch):
    steps = []
    jaculus.solve("double_integrator", progress=lambda *step: steps.append(step))
    told = shown_by(monkeypatch, lambda: jaculus.solve("double_integrator", progress=True))
    assert f"double_integrator: {len(steps)}iteration" in told and "objective=2" in told


def test_a_diagnosis_shows_its_stages(monkeypatch, pendulum_trials):
    stages = []
    quick = {"largest_model": 1, "kept_singles": 1}
    jaculus.diagnose(pendulum_trials, settings=quick, progress=stages.append)
    told = shown_by(
        monkeypatch, lambda: jaculus.diagnose(pendulum_trials, settings=quick, progress=True)
    )
    assert all(stage in told for stage in stages) and f"{len(stages)}stage" in told


def test_a_study_shows_how_many_points_are_done(monkeypatch):
    told = shown_by(monkeypatch, lambda: jaculus.study("drag_bench", progress=True))
    assert "study: 100%" in told


def test_an_exception_of_the_progress_ends_a_study():
    seen = []

    def stop(done, points):
        seen.append(done)
        raise LookupError(f"{done} of {points}")

    with pytest.raises(LookupError, match="1 of"):
        jaculus.study("drag_bench", progress=stop)
    assert seen == [1]
