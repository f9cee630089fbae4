"""Runs every program of examples/*.py as its reader would, and checks what its comments say it prints."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("JACULUS_DATA", "../shared/data")).resolve()
specification = importlib.util.spec_from_file_location("run_docs", ROOT / "tests/docs/run_docs.py")
docs = importlib.util.module_from_spec(specification)
specification.loader.exec_module(docs)
OPTIONAL = {"distributed", "ray", "rosbags", "submitit"}
PROGRAMS = sorted((ROOT / "examples").glob("*.py"))


def test_there_are_examples():
    assert len(PROGRAMS) >= 7


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.stem)
def test_an_example_runs_and_prints_what_it_says(program, tmp_path):
    text = program.read_text()
    for module in OPTIONAL & set(re.findall(r"^(?:from|import) (\w+)", text, re.M)):
        pytest.importorskip(module, reason=f"this example needs {module}")
    if 'environ["JACULUS_DATA"]' in text and not DATA.is_dir():
        pytest.skip("no shared data")
    environment = {**os.environ, "MPLBACKEND": "Agg", "JACULUS_DATA": str(DATA)}
    done = subprocess.run(
        [sys.executable, program], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for expected in re.findall(r"^# prints: (.+)", text, re.M):
        assert docs.occurs(expected, done.stdout), f"{expected!r} is not in\n{done.stdout}"
    for picture in re.findall(r'savefig\("(.+?)"\)', text):
        assert (tmp_path / picture).stat().st_size > 5000
