"""Writes the pages of the site, and its configuration.

    stage.py --program JACULUS --worker SHIM.js --work build

Pages of docs/ and the repository's own, examples and their notebooks, and the reference go into
WORK/site_pages; WORK/mkdocs.yml is docs/site/mkdocs.yml with the whole navigation.
"""

import argparse
import pathlib
import shutil
import subprocess

import examples
import reference
import yaml
from links import MOVED, ROOT, page


def write_pages(pages):
    """Pages that people wrote; files that they lead to come along as text."""
    copied = set()
    sources = [path for path in sorted((ROOT / "docs").rglob("*")) if path.is_file()]
    for path in sources:
        source = str(path.relative_to(ROOT))
        if source.startswith("docs/site/"):
            continue
        target = MOVED.get(source, source.removeprefix("docs/"))
        (pages / target).parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".md":
            (pages / target).write_text(page(source, target, copied))
        else:
            shutil.copy(path, pages / target)
    for source in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        (pages / MOVED[source]).write_text(page(source, MOVED[source], copied))
    licence = (ROOT / "LICENSE").read_text()
    (pages / MOVED["LICENSE"]).write_text(f"# Licence\n\n```text\n{licence}```\n")
    for source in copied:
        target = pages / f"files/{source}.txt"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / source, target)


def write_doxygen(pages, work):
    """The public headers as HTML, beside the pages."""
    lines = (ROOT / "docs/site/Doxyfile").read_text()
    lines += f"OUTPUT_DIRECTORY = {work}\nHTML_OUTPUT = {pages.relative_to(work)}/cpp\n"
    lines += f"INPUT_FILTER = {ROOT}/docs/site/header_filter\n"
    done = subprocess.run(["doxygen", "-"], input=lines, text=True, cwd=ROOT, capture_output=True)
    if done.returncode or done.stderr:
        raise SystemExit(f"doxygen:\n{done.stderr}")


def write_configuration(work, parts):
    configuration = yaml.safe_load((ROOT / "docs/site/mkdocs.yml").read_text())

    def filled(entry):
        ((title, place),) = entry.items() if isinstance(entry, dict) else ((None, entry),)
        return {title: parts.get(place, place) if isinstance(place, str) else place}

    configuration["nav"] = [filled(entry) for entry in configuration["nav"]]
    (work / "mkdocs.yml").write_text(yaml.safe_dump(configuration, sort_keys=False))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--worker", type=pathlib.Path, required=True, help="iframe-worker's shim")
    options = parser.parse_args()
    work = options.work.resolve()
    pages = work / "site_pages"
    shutil.rmtree(pages, ignore_errors=True)
    pages.mkdir(parents=True)
    write_pages(pages)
    (pages / "assets").mkdir()
    shutil.copy(ROOT / "docs/site/extra.css", pages / "assets")
    shutil.copy(options.worker, pages / "assets/iframe-worker.js")
    parts = {
        "examples": examples.write(pages),
        "reference": reference.write(options.program.resolve(), pages),
    }
    write_doxygen(pages, work)
    write_configuration(work, parts)


if __name__ == "__main__":
    main()
