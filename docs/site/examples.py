"""examples/*.py as pages, and as notebooks by jupytext: one source."""

import ast
import shutil

import jupytext
import nbformat
from links import ROOT

ORDER = [
    "first_leap",
    "tail_for_my_robot",
    "paper_figures",
    "spoil_and_find_out",
    "unknown_cause",
    "real_minitaur",
    "real_ak80",
    "ros_bag",
    "plan_in_pinocchio",
    "plan_in_crocoddyl",
    "plan_in_mujoco",
    "cluster_slurm",
    "cluster_dask",
    "cluster_ray",
]


def programs():
    found = {path.stem: path for path in sorted((ROOT / "examples").glob("*.py"))}
    return [found.pop(name) for name in ORDER if name in found] + list(found.values())


def headline(path):
    """The first sentence of what a program says of itself, and the rest."""
    first, _, rest = ast.get_docstring(ast.parse(path.read_text())).partition("\n")
    return first.strip(), rest.strip()


def notebook(path):
    """The program as a notebook; its docstring and the titles of its cells are text."""
    made = jupytext.read(path, fmt="py:percent")
    first, rest = headline(path)
    made.cells[0] = nbformat.v4.new_markdown_cell(f"# {first}\n\n{rest}", id="head")
    for k in reversed(range(len(made.cells))):
        if title := made.cells[k].metadata.get("title"):
            made.cells.insert(k, nbformat.v4.new_markdown_cell(f"## {title}", id=f"title-{k}"))
    made.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
    return made


def example_page(path):
    first, rest = headline(path)
    code = path.read_text().split('"""', 2)[2].strip("\n")
    return (
        f"# {path.stem}\n\n{first}\n\n{rest}\n\n"
        f"To download: [{path.name}]({path.name}), [{path.stem}.ipynb]({path.stem}.ipynb)\n\n"
        f"```python\n{code}\n```\n"
    )


def write(pages):
    """Pages and notebooks below `pages`; returns their part of the navigation."""
    folder = pages / "examples"
    folder.mkdir(parents=True)
    rows = ["# Examples", "", "Programs that a test runs, as they are and as notebooks.", ""]
    rows += ["| example | what it does |", "|---|---|"]
    navigation = ["examples/index.md"]
    for path in programs():
        jupytext.write(notebook(path), folder / f"{path.stem}.ipynb")
        shutil.copy(path, folder)
        (folder / f"{path.stem}.md").write_text(example_page(path))
        rows.append(f"| [{path.stem}]({path.stem}.md) | {headline(path)[0]} |")
        navigation.append({path.stem: f"examples/{path.stem}.md"})
    rows += ["", "In C++, against the installed library:", ""]
    for path in sorted((ROOT / "examples").glob("*/main.cpp")):
        name = path.parent.name
        (folder / f"cpp_{name}.md").write_text(
            f"# {name}/main.cpp\n\n```cpp\n{path.read_text()}```\n"
        )
        rows.append(f"- [{name}](cpp_{name}.md)")
        navigation.append({f"{name} (C++)": f"examples/cpp_{name}.md"})
    (folder / "index.md").write_text("\n".join(rows) + "\n")
    return navigation
