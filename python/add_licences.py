"""Puts the licence texts of the libraries that a repaired wheel holds beside them.

  add_licences.py WHEEL

The libraries are those of this Debian; each of its packages has its terms in /usr/share/doc.
"""
import pathlib
import re
import subprocess
import sys
import tempfile


def package_of(library):
    """Debian's package of a library as auditwheel renames it: libipopt-1a2b3c4d.so.1.9.9,
    libscotch-7-1a2b3c4d.0.3.so."""
    name = re.sub(r"-[0-9a-f]{8}(?=\.)", "", library)
    found = subprocess.run(["dpkg", "-S", f"*/{name}"], capture_output=True, text=True, check=False)
    packages = [line.split(":")[0] for line in found.stdout.splitlines()]
    return next((p for p in packages if not p.endswith("-dev")), None)


def main():
    wheel = pathlib.Path(sys.argv[1]).resolve()
    run = [sys.executable, "-m", "wheel"]
    with tempfile.TemporaryDirectory() as work:
        subprocess.run([*run, "unpack", wheel, "-d", work], check=True, stdout=subprocess.DEVNULL)
        (tree,) = pathlib.Path(work).iterdir()
        (licences,) = [folder / "licenses" for folder in tree.glob("jaculus-*.dist-info")]
        licences.mkdir(exist_ok=True)
        for library in sorted(path.name for path in tree.glob("jaculus.libs/*")):
            package = package_of(library)
            terms = pathlib.Path(f"/usr/share/doc/{package}/copyright")
            if package is None or not terms.exists():
                sys.exit(f"{library}: no package of this Debian states its licence")
            (licences / f"{package}.txt").write_bytes(terms.read_bytes())
        subprocess.run([*run, "pack", tree, "-d", wheel.parent], check=True)


main()
