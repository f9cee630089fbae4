#!/usr/bin/env python3
"""Runs what a page of the documentation tells its reader to type; checks what it says is printed.

  run_docs.py --program JACULUS --source TREE --work FOLDER [--without mujoco] [--data FOLDER] PAGE
  run_docs.py --links --source TREE

A page's fenced blocks, in order, in one scratch folder with links to models/, problems/, effects/, examples/:
  sh run                 is run; every command must succeed
  sh run needs WHAT      the same, where WHAT (mujoco, data) is there
  sh exits N             is run; its last command ends with N
  sh not run: REASON     is left alone; an sh block without a mark is an error
  yaml                   is written to the file that its first line names: "# my_leap.yaml"
  text prints            every line of it occurs in what the blocks since the last such block
                         printed: the same words in a row, numbers within 2 %
  ANY from FILE          stands in FILE of the source tree, word for word
With --links: every relative link of every page leads to a file, and the README has at most 900 words.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

TOLERANCE = 0.02  # relative; compilers differ in the last digits, and a page needs no more
MOST_WORDS = 900  # of the README
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")


class Fault(Exception):
    pass


def blocks(page):
    """(line, info, text) of every fenced block."""
    found, start, info, lines = [], None, None, []
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if not line.startswith("```"):
            if start is not None:
                lines.append(line)
        elif start is None:
            start, info, lines = number, line[3:].strip(), []
        else:
            found.append((start, info, "\n".join(lines) + "\n"))
            start = None
    if start is not None:
        raise Fault(f"{page}:{start}: this block is never closed")
    return found


def tokens(line):
    """Words and numbers of a line; brackets and commas stand alone."""
    return re.sub(r"([\[\](),:;%])", r" \1 ", line).split()


def alike(expected, actual):
    if expected == actual:
        return True
    if not (NUMBER.match(expected) and NUMBER.match(actual)):
        return False
    a, b = float(expected), float(actual)
    return abs(a - b) <= TOLERANCE * max(abs(a), abs(b))


def occurs(line, printed):
    """Whether the words of a line stand in a row in some printed line."""
    wanted = tokens(line)
    for other in printed.splitlines():
        words = tokens(other)
        for i in range(len(words) - len(wanted) + 1):
            if all(map(alike, wanted, words[i:i + len(wanted)])):
                return True
    return False


def run_block(place, text, wanted, options, environment):
    done = subprocess.run(["sh", "-eu", "-c", text], cwd=options.work, env=environment, text=True,
                          check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != wanted:
        raise Fault(f"{place}: ended with {done.returncode} instead of {wanted}\n{text}{done.stdout}")
    return done.stdout


def prepare(options):
    if options.work.exists():
        shutil.rmtree(options.work)
    programs = options.work / "bin"
    programs.mkdir(parents=True)
    (programs / "jaculus").symlink_to(options.program.resolve())
    for folder in ("models", "problems", "effects", "examples"):
        if not (options.source / folder).exists():
            continue
        (options.work / folder).symlink_to(options.source.resolve() / folder)
    environment = dict(os.environ, PATH=f"{programs.resolve()}{os.pathsep}{os.environ['PATH']}")
    if options.data:
        environment["DATA"] = str(options.data.resolve())
    return environment


def run_page(options):
    environment = prepare(options)
    missing = set(options.without) | (set() if options.data else {"data"})
    printed, skipped, count = "", False, 0
    for line, info, text in blocks(options.page):
        place = f"{options.page}:{line}"
        kind, _, mark = info.partition(" ")
        if mark.startswith("from "):
            if text not in (options.source / mark[5:]).read_text():
                raise Fault(f"{place}: this does not stand in {mark[5:]} as it is")
        elif kind == "yaml":
            name = re.match(r"# ([\w./-]+\.yaml)\n", text)
            if name:
                file = options.work / name[1]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
        elif kind == "text" and mark == "prints":
            for expected in filter(str.strip, text.splitlines()):
                if not skipped and not occurs(expected, printed):
                    raise Fault(
                        f"{place}: '{expected.strip()}' is not in what was printed:\n{printed}")
            printed, skipped = "", False
        elif kind == "sh":
            run = re.fullmatch(r"run(?: needs (\w+))?|exits (\d+)", mark)
            if run is None:
                if re.fullmatch(r"not run: .+", mark):
                    continue
                raise Fault(f"{place}: an sh block is marked 'run', 'run needs WHAT', 'exits N' or "
                            "'not run: REASON'")
            if run[1] in missing:
                print(f"{place}: not run, there is no {run[1]}")
                skipped = True
                continue
            print(f"{place}: {text.strip()}", flush=True)
            printed += run_block(place, text, int(run[2] or 0), options, environment)
            count += 1
    print(f"{options.page}: {count} blocks run")


def pages(source):
    return sorted([*source.glob("*.md"), *source.glob("docs/**/*.md"), *source.glob("examples/**/*.md")])


def check_links(options):
    faults = []
    for page in pages(options.source):
        text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"\w+:", target) or target.startswith("#"):
                continue
            if not (page.parent / target.split("#")[0]).exists():
                faults.append(f"{page}: leads to {target}, which is not there")
    words = len((options.source / "README.md").read_text().split())
    if words > MOST_WORDS:
        faults.append(f"README.md: {words} words; allowed: {MOST_WORDS}")
    if faults:
        raise Fault("\n".join(faults))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", nargs="?", type=pathlib.Path)
    parser.add_argument("--program", type=pathlib.Path)
    parser.add_argument("--source", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path)
    parser.add_argument("--data", type=pathlib.Path)
    parser.add_argument("--without", nargs="*", default=[])
    parser.add_argument("--links", action="store_true")
    options = parser.parse_args()
    if options.data and not options.data.is_dir():
        options.data = None
    try:
        check_links(options) if options.links else run_page(options)
    except Fault as fault:
        sys.exit(str(fault))


if __name__ == "__main__":
    main()
