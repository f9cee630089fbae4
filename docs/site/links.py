"""Pages of the repository as pages of the site: links, lists and fences as MkDocs reads them."""

import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
# What lies outside docs/, or has another name on the site.
MOVED = {
    "README.md": "overview.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "LICENSE": "licence.md",
    "docs/gallery.md": "index.md",
    "examples": "examples/index.md",
    "effects": "reference/files_effects.md",
    "problems": "reference/files_problems.md",
}


def site_path(path, copied):
    """Where a file of the repository stands on the site. Files that are no page are copied as text."""
    if path in MOVED:
        return MOVED[path]
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    parts = pathlib.PurePosixPath(path).parts
    if parts[0] in ("problems", "effects") and path.endswith(".yaml"):
        return f"{MOVED[parts[0]]}#{parts[-1].removesuffix('.yaml')}"
    if parts[0] == "examples" and len(parts) == 2 and path.endswith(".py"):
        return path.removesuffix(".py") + ".md"
    copied.add(path)
    return f"files/{path}.txt"


def move_links(text, page, target, copied):
    """Relative links of `page`, a path in the repository, for its place `target` on the site."""

    def moved(match):
        link, hash_, anchor = match[1].partition("#")
        if re.match(r"\w+:", match[1]) or not link:
            return match[0]
        path = os.path.normpath(os.path.join(os.path.dirname(page), link))
        found = site_path(path, copied)
        if "#" in found:
            found, _, anchor = found.partition("#")
            hash_ = "#"
        return f"]({os.path.relpath(found, os.path.dirname(target) or '.')}{hash_}{anchor})"

    return re.sub(r"\]\(([^)\s]+)\)", moved, text)


def plain_fences(text):
    """```sh run needs data -> ```sh: the marks are those of tests/docs/run_docs.py."""
    return re.sub(r"^( *```\w+) .*$", r"\1", text, flags=re.M)


def widen_lists(text):
    """What belongs to an item of a list is indented by four: Python-Markdown asks for that."""
    lines, inside = [], 0
    for line in text.split("\n"):
        blank = not line.strip()
        indent = len(line) - len(line.lstrip())
        item = re.match(r"(\d+\.|-) ", line)
        if item:
            inside = len(item[0])
        elif not blank and indent < inside:
            inside = 0
        if inside and indent >= inside:
            line = " " * (4 - inside) + line
        lines.append(line)
    return "\n".join(lines)


def outside_fences(text, change):
    """`change` applied to what isn't code."""
    parts = re.split(r"(^ *```.*?^ *```$)", text, flags=re.M | re.S)
    return "".join(part if k % 2 else change(part) for k, part in enumerate(parts))


def page(source, target, copied):
    """The text of a page of the repository for the site."""
    text = widen_lists((ROOT / source).read_text())
    text = outside_fences(text, lambda part: move_links(part, source, target, copied))
    return plain_fences(text)
