"""The types of the bindings, which type checkers read."""
import ast
import inspect
import os
import pathlib
import subprocess
import sys

import pytest

import jaculus
from jaculus import _core

ROOT = pathlib.Path(__file__).parents[2]
STUB = pathlib.Path(jaculus.__file__).parent / "_core.pyi"
installed = pytest.mark.skipif(not STUB.exists(), reason="stubs come with an installed package")


@installed
def test_stubs_are_python_and_have_all_of_the_module():
    declared = {node.name for node in ast.parse(STUB.read_text()).body
                if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    there = {name for name, value in vars(_core).items()
             if inspect.isclass(value) or callable(value) and not name.startswith("_")}
    assert there and there <= declared


def checked(folder, *arguments):
    """What mypy says, run in a folder."""
    pytest.importorskip("mypy")
    environment = dict(os.environ)
    if "site-packages" not in STUB.parts:
        environment["MYPYPATH"] = os.fspath(STUB.parents[1])
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml",
               "--cache-dir", folder / "cache", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment)


@installed
def test_a_checker_of_types_finds_no_fault_in_the_package(tmp_path):
    done = checked(tmp_path, "-p", "jaculus")
    assert done.returncode == 0, done.stdout + done.stderr


@installed
def test_a_checker_of_types_knows_what_a_user_calls(tmp_path):
    (tmp_path / "use.py").write_text("import jaculus\nreveal_type(jaculus.solve('x').states)\n"
                                     "reveal_type(jaculus.__version__)\njaculus.solve(1.0)\n")
    done = checked(tmp_path, "use.py")
    assert 'Revealed type is "numpy.ndarray' in done.stdout, done.stdout
    assert 'Revealed type is "str"' in done.stdout
    assert '"solve" has incompatible type "float"' in done.stdout
