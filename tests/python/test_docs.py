"""Runs the Python blocks of docs/python.md in order, in one namespace, and checks what they print."""
import contextlib
import importlib.util
import io
import pathlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
specification = importlib.util.spec_from_file_location("run_docs", ROOT / "tests/docs/run_docs.py")
docs = importlib.util.module_from_spec(specification)
specification.loader.exec_module(docs)


def test_every_block_runs_and_prints_what_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    namespace, printed, count = {}, "", 0
    for line, info, text in docs.blocks(ROOT / "docs/python.md"):
        if info == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(text, f"docs/python.md:{line}", "exec"), namespace)
            printed += out.getvalue()
            count += 1
        elif info == "text prints":
            for expected in filter(str.strip, text.splitlines()):
                assert docs.occurs(expected, printed), f"{line}: {expected!r} is not in\n{printed}"
            printed = ""
        else:
            assert info.startswith("sh not run: "), f"{line}: a block is python, 'text prints' or not run"
    assert count >= 3
