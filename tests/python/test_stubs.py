"""The types of the bindings, which type checkers read."""
import ast
import inspect
import pathlib

import pytest

import jaculus
from jaculus import _core

STUB = pathlib.Path(jaculus.__file__).parent / "_core.pyi"


@pytest.mark.skipif(not STUB.exists(), reason="stubs come with an installed package")
def test_stubs_are_python_and_have_all_of_the_module():
    declared = {node.name for node in ast.parse(STUB.read_text()).body
                if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    there = {name for name, value in vars(_core).items()
             if inspect.isclass(value) or callable(value) and not name.startswith("_")}
    assert there and there <= declared
