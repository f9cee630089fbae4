"""Runs examples as the notebooks that the site offers, where jupytext and nbclient are installed."""

import re
import sys

import pytest

pytest.importorskip("jupytext", reason="notebooks need jupytext")
nbclient = pytest.importorskip("nbclient", reason="notebooks need nbclient and ipykernel")
pytest.importorskip("ipykernel", reason="notebooks need nbclient and ipykernel")

from test_examples import PROGRAMS, ROOT, docs, pass_over, surroundings  # noqa: E402

sys.path.insert(0, str(ROOT / "docs/site"))
import examples  # noqa: E402

# Those of clusters start processes that import the program, which a notebook isn't.
NOTEBOOKS = [program for program in PROGRAMS if not program.stem.startswith("cluster_")]


@pytest.mark.parametrize("program", NOTEBOOKS, ids=lambda program: program.stem)
def test_an_example_runs_as_a_notebook_and_prints_what_it_says(program, tmp_path, monkeypatch):
    text = program.read_text()
    pass_over(text)
    notebook = examples.notebook(program)
    kinds = [cell.cell_type for cell in notebook.cells]
    assert kinds[:3] == ["markdown", "markdown", "code"] and kinds.count("code") >= 2
    for name, value in surroundings().items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    nbclient.NotebookClient(
        notebook, timeout=1800, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    ).execute()
    printed = "".join(
        output.get("text", "")
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
    )
    for expected in re.findall(r"^# prints: (.+)", text, re.M):
        assert docs.occurs(expected, printed), f"{expected!r} is not in\n{printed}"
