"""Runs every program of examples/*.py as its reader would, and checks what its comments and the gallery
say it prints."""

import importlib.metadata
import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("JACULUS_DATA", ROOT / "../shared/data")).resolve()
specification = importlib.util.spec_from_file_location("run_docs", ROOT / "tests/docs/run_docs.py")
docs = importlib.util.module_from_spec(specification)
specification.loader.exec_module(docs)
OPTIONAL = {"crocoddyl", "distributed", "mujoco", "pinocchio", "ray", "rosbags", "submitit"}
PROGRAMS = sorted((ROOT / "examples").glob("*.py"))
GALLERY = ROOT / "docs/gallery.md"
LARGEST_PICTURE = 150_000  # bytes


def gallery():
    """(program, text) of every section of the gallery that shows one."""
    sections = GALLERY.read_text().split("\n## ")[1:]
    return [(re.search(r"\(\.\./(examples/\w+\.py)\)", text)[1], text) for text in sections]


def pictures(text):
    return [GALLERY.parent / picture for picture in re.findall(r"\]\((pictures/[^)]+)\)", text)]


def fences(text, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```$", text, re.M | re.S)


def pass_over(text):
    """Skips the test where a program needs what isn't here."""
    for module in OPTIONAL & set(re.findall(r"^(?:from|import) (\w+)", text, re.M)):
        pytest.importorskip(module, reason=f"this example needs {module}")
    if "import crocoddyl" in text:
        versions = [importlib.metadata.version(name) for name in ("crocoddyl", "pin")]
        if versions[0] == "3.2.1" and not versions[1].startswith("4.0."):
            pytest.skip(f"crocoddyl 3.2.1 crashes with pin {versions[1]}: pip install pin==4.0.0")
    if 'environ["JACULUS_DATA"]' in text and not DATA.is_dir():
        pytest.skip("no shared data")


def surroundings():
    return {**os.environ, "MPLBACKEND": "Agg", "JACULUS_DATA": str(DATA)}


def test_there_are_examples():
    assert len(PROGRAMS) >= 12


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.stem)
def test_an_example_runs_and_prints_what_it_and_the_gallery_say(program, tmp_path):
    text = program.read_text()
    pass_over(text)
    done = subprocess.run(
        [sys.executable, program], cwd=tmp_path, env=surroundings(), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    promised = re.findall(r"^# prints: (.+)", text, re.M)
    for shown, section in gallery():
        if ROOT / shown == program:
            promised += "".join(fences(section, "text prints")).splitlines()
    for expected in filter(str.strip, promised):
        assert docs.occurs(expected, done.stdout), f"{expected!r} is not in\n{done.stdout}"
    for picture in re.findall(r'savefig\("(.+?)"', text):
        assert (tmp_path / picture).stat().st_size > 5000


@pytest.mark.parametrize("section", gallery(), ids=lambda section: section[0])
def test_the_gallery_shows_what_its_program_has_and_draws(section):
    shown, text = section
    program = (ROOT / shown).read_text()
    code = fences(text, f"python from {re.escape(shown)}")
    assert code, "a few lines of the program"
    for lines in code:
        assert lines in program
    for picture in pictures(text):
        assert f'savefig("{picture.name}"' in program
        assert picture.stat().st_size < LARGEST_PICTURE
