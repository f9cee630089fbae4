import numpy as np
import pandas as pd
import pytest

import jaculus

COLUMNS = {
    "format": "jaculus-columns/1",
    "gaps": ["lost"],
    "channels": {
        "time": {"column": "t", "unit": "ms"},
        "pendulum": {"columns": ["a", "b"], "unit": "deg", "scale": 2, "offset": 10},
        "pendulum_torque": {"column": "tau", "unit": "N m"},
    },
}
OPTIONS = {
    "columns": COLUMNS,
    "robot": "ak80_pendulum",
    "experiment": "pendulum",
    "controller": "{kind: measured, input: torque}",
}


@pytest.fixture
def frame():
    t = 5.0 + 2.0 * np.arange(20)
    return pd.DataFrame(
        {
            "t": t,
            "a": np.sin(t),
            "b": np.cos(t),
            "tau": np.where(t == 9.0, np.nan, 0.1 * t),
            "label": "x",
        }
    )


def expect(dataset, frame):
    stream = dataset.trials[0]["joints"]
    np.testing.assert_allclose(stream.time, (frame.t - 5.0) / 1000.0, atol=1e-15)
    np.testing.assert_allclose(stream["pendulum"], np.deg2rad(frame.a + frame.b + 10.0), rtol=1e-14)
    np.testing.assert_allclose(stream["pendulum_torque"], frame.tau, rtol=1e-15)
    assert stream.units == {"pendulum": "rad", "pendulum_torque": "N m"}
    assert dataset.notes[-1] == "trial_01: columns left out: label"


def test_a_frame_of_pandas_becomes_a_dataset(frame, tmp_path):
    expect(jaculus.import_table(frame, tmp_path / "out", **OPTIONS), frame)


def test_parquet_becomes_a_dataset(frame, tmp_path):
    pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")
    frame.to_parquet(tmp_path / "log.parquet")
    expect(jaculus.import_table(tmp_path / "log.parquet", tmp_path / "out", **OPTIONS), frame)


def test_csv_becomes_the_dataset_that_the_command_makes(frame, tmp_path):
    frame.to_csv(tmp_path / "log.csv", index=False, na_rep="lost")
    expect(jaculus.import_table(tmp_path / "log.csv", tmp_path / "out", **OPTIONS), frame)


def test_times_of_day_count_from_the_first(frame, tmp_path):
    frame["t"] = pd.Timestamp("2026-01-02T03:04:05") + pd.to_timedelta(frame.t, unit="ms")
    columns = {**COLUMNS, "channels": {**COLUMNS["channels"], "time": {"column": "t", "unit": "s"}}}
    dataset = jaculus.import_table(frame, tmp_path / "out", **{**OPTIONS, "columns": columns})
    np.testing.assert_allclose(dataset.trials[0]["joints"].time, 0.002 * np.arange(20), atol=1e-12)


@pytest.mark.parametrize(
    "spoil, told",
    [
        (
            lambda f: f.rename(columns={"tau": "torque"}),
            "no column 'tau'.*allowed: t, a, b, torque, label",
        ),
        (lambda f: f.assign(tau="x"), "column 'tau' holds"),
        (lambda f: f.iloc[::-1], "rising times"),
    ],
)
def test_faults_of_a_table_are_named(frame, tmp_path, spoil, told):
    with pytest.raises(jaculus.InputError, match=told):
        jaculus.import_table(spoil(frame), tmp_path / "out", **OPTIONS)


def test_start_and_cut_select_samples(frame, tmp_path):
    stream = jaculus.import_table(
        frame, tmp_path / "out", start="pendulum_torque>1.0", cut=(-0.002, 0.004), **OPTIONS
    ).trials[0]["joints"]
    np.testing.assert_allclose(stream.time, [-0.002, 0.0, 0.002, 0.004], atol=1e-12)
    with pytest.raises(jaculus.InputError, match="FROM below TO"):
        jaculus.import_table(frame, tmp_path / "out", cut=(1.0, 0.0), **OPTIONS)


def test_a_fault_names_the_file_or_the_argument(frame, tmp_path):
    frame.iloc[::-1].to_csv(tmp_path / "log.csv", index=False, na_rep="lost")
    with pytest.raises(jaculus.InputError, match="rising times") as caught:
        jaculus.import_table(tmp_path / "log.csv", tmp_path / "out", **OPTIONS)
    assert caught.value.file == str(tmp_path / "log.csv")
    for key, wrong in (("start", "nan"), ("start", "soon"), ("start", "no>1"), ("cut", (1, 0))):
        with pytest.raises(jaculus.InputError, match=f"^{key}: ") as caught:
            jaculus.import_table(frame, tmp_path / "out", **{key: wrong}, **OPTIONS)
        assert (caught.value.key, caught.value.file) == (key, None)
