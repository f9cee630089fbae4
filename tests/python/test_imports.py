"""What the package imports, and when."""
import ast
import pathlib
import subprocess
import sys

import pytest

import jaculus

SOURCE = pathlib.Path(jaculus.__file__).read_text()


def declared_to_checkers():
    """Names of jaculus by the module that they are from, as checkers of types see them."""
    blocks = [node for node in ast.parse(SOURCE).body if isinstance(node, ast.If)]
    return {entry.module: [name.name for name in entry.names]
            for block in blocks for entry in block.body if isinstance(entry, ast.ImportFrom)}


def test_every_name_is_there_and_checkers_of_types_know_the_same():
    assert declared_to_checkers() == jaculus._MODULES
    assert {*jaculus._MODULE_OF, "__version__"} == set(jaculus.__all__) <= set(dir(jaculus))
    for name in jaculus.__all__:
        assert getattr(jaculus, name) is not None


def test_modules_of_the_package_are_attributes_and_other_names_are_errors():
    assert jaculus.plans.solve is jaculus.solve
    with pytest.raises(AttributeError, match="no attribute 'solves'"):
        jaculus.solves


def test_a_solved_and_saved_leap_needs_no_numpy_until_an_array_is_asked_for(tmp_path):
    code = f"""
import sys, jaculus
plan = jaculus.solve("double_integrator")
plan.save({str(tmp_path)!r})
assert plan.summary and plan.objective and plan.phase and plan.units
print(sorted({{"numpy", "pandas", "tqdm"}} & set(sys.modules)))
print(plan.states.shape == (len(plan["time"]), len(plan.state_names)), "numpy" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.split("\n")[:2] == ["[]", "True True"]
