"""Pages of reference: what the program says of itself, and the files that come with it."""

import itertools
import os
import re
import subprocess

from links import ROOT


def printed(program, *arguments):
    environment = {**os.environ, "COLUMNS": "100"}
    done = subprocess.run(
        [program, *arguments], capture_output=True, text=True, check=True, env=environment
    )
    return done.stdout.strip("\n")


def fenced(text, kind="text"):
    return f"```{kind}\n{text.rstrip()}\n```\n"


def subcommands(help_text):
    """(name, what it does) of the subcommands that a --help lists."""
    listed = help_text.partition("Subcommands:\n")[2].partition("\n\n")[0]
    return re.findall(r"^  (\w+) +(.+)$", listed, re.M)


def command_sections(program, words, level):
    """A command's --help, and those of its subcommands below it."""
    text = printed(program, *words, "--help")
    page = f"{'#' * level} jaculus {' '.join(words)}\n\n{fenced(text)}\n"
    for name, _ in subcommands(text):
        page += command_sections(program, [*words, name], level + 1)
    return page


def write_commands(program, folder):
    top = printed(program, "--help")
    rows = [
        "# Command line",
        "",
        "Printed by the program; [commands and files](../commands.md)",
        "",
    ]
    rows[2] += " tells more.\n\n| command | what it does |\n|---|---|"
    rows.pop()
    navigation = ["reference/command_line.md"]
    for name, meaning in subcommands(top):
        (folder / f"command_{name}.md").write_text(command_sections(program, [name], 1))
        rows.append(f"| [{name}](command_{name}.md) | {meaning} |")
        navigation.append({name: f"reference/command_{name}.md"})
    (folder / "command_line.md").write_text("\n".join(rows) + "\n\n" + fenced(top))
    return navigation


def explained(title, intro, text):
    """A page of `--explain`: lines that aren't indented head what follows them."""
    page, lines = f"# {title}\n\n{intro}\n", text.split("\n")
    for block in re.split(r"\n\n+", "\n".join(lines)):
        head, _, rest = block.partition("\n")
        if rest and all(line.startswith(" ") for line in rest.split("\n")):
            name, _, caption = head.partition(": ")
            kinds = name in ("constraints", "costs")  # "constraints: friction" is a name
            page += f"\n## {head if kinds else name}\n\n"
            page += f"{caption[:1].upper() + caption[1:]}.\n\n" if caption and not kinds else ""
            page += fenced(rest)
        else:
            page += "\n" + block + "\n"
    return page


def write_explanations(program, folder):
    pages = {
        "problem_file": ("Problem files", "check"),
        "effects": ("Effects", "simulate"),
        "settings": ("Settings of a diagnosis", "diagnose"),
    }
    for name, (title, command) in pages.items():
        text = explained(
            title,
            f"What `jaculus {command} --explain` prints.",
            printed(program, command, "--explain"),
        )
        (folder / f"{name}.md").write_text(text)
    return [{title: f"reference/{name}.md"} for name, (title, _) in pages.items()]


def write_files(folder):
    """Files that come with jaculus, comments and all."""
    kinds = {
        "problems": ("Problems, experiments and studies that come along", "*.yaml"),
        "models": ("Robots that come along", "*/robot.yaml"),
        "effects": ("Effects in files", "*.yaml"),
    }
    navigation = []
    for kind, (title, pattern) in kinds.items():
        text = f"# {title}\n"
        for path in sorted((ROOT / kind).glob(pattern)):
            name = path.parent.name if path.name == "robot.yaml" else path.stem
            text += f"\n## {name} {{#{name}}}\n\n{fenced(path.read_text(), 'yaml')}"
        (folder / f"files_{kind}.md").write_text(text)
        navigation.append({title: f"reference/files_{kind}.md"})
    return navigation


PYTHON = [
    ("Plans", ["solve", "compare", "Plan", "Comparison", "JointTrajectory"]),
    ("Robots and problems", ["load_robot", "import_robot", "load_problem", "shipped", "Robot", "Problem"]),
    ("Trials and logs", ["simulate", "load_dataset", "import_bag", "import_table"]),
    ("", ["Dataset", "Trial", "Stream"]),
    ("Diagnoses", ["diagnose", "Diagnosis"]),
    ("Preflights", ["preflight", "Preflight"]),
    ("Effects and terms of your own", ["Effect", "check_effect", "EffectChecks", "Term", "Row", "Point",
                                       "check_derivatives", "DerivativeCheck"]),
    ("Studies", ["study", "Study"]),
    ("Many machines", ["map"]),
    ("Errors", ["InputError", "Interrupted"]),
]


def write_python(folder):
    source = (ROOT / "python/jaculus/__init__.py").read_text()
    listed = re.search(r"__all__ = \[.*?\]", source, re.S)
    exported = set(re.findall(r'"(\w+)"', listed[0])) - {"__version__"}
    shown = {name for _, names in PYTHON for name in names}
    if missing := exported - shown:
        raise SystemExit(f"docs/site/reference.py: PYTHON lacks {', '.join(sorted(missing))}")
    text = "# Python\n\n::: jaculus\n    options: {members: false, show_root_heading: false}\n"
    for title, names in PYTHON:
        text += f"\n## {title}\n" if title else ""
        for name in names:
            text += f"\n::: jaculus.{name}\n    options: {{heading_level: 3}}\n"
    (folder / "python.md").write_text(text)
    return [{"Python": "reference/python.md"}]


BACKSLASHED = r"\\\1"  # what Markdown would take for its own


def header_sentence(path):
    """The first sentence of a header's opening comment."""
    lines = re.findall(r"^///? ?(.*)$", path.read_text(), re.M)
    comment = " ".join(itertools.takewhile(lambda line: re.match(r"\S", line), lines)) + " "
    return re.split(r"[.:;,] (?! )", comment)[0].strip() if lines else ""


def write_cpp(folder):
    rows = ["# C++", "", "[Classes, functions and files](../cpp/index.html) by doxygen. The public"]
    rows[2] += ' headers, `#include "jaculus/..."`:'
    for module in sorted((ROOT / "include/jaculus").iterdir()):
        rows += ["", f"## {module.name}", "", "| header | holds |", "|---|---|"]
        for path in sorted(module.glob("*.h")):
            rows.append(
                f"| {path.name} | {re.sub(r'([][|<*_])', BACKSLASHED, header_sentence(path))} |"
            )
    (folder / "cpp.md").write_text("\n".join(rows) + "\n")
    return [{"C++": "reference/cpp.md"}]


def write(program, pages):
    """Pages below `pages`; returns their part of the navigation."""
    folder = pages / "reference"
    folder.mkdir(parents=True)
    return [
        {"Commands and files": "commands.md"},
        {"Command line": write_commands(program, folder)},
        *write_explanations(program, folder),
        *write_python(folder),
        *write_cpp(folder),
        {"Files": write_files(folder)},
    ]
