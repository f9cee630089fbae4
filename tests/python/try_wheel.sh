#!/bin/sh
# Tries a wheel as scripts/wheel --test says.
# Usage: try_wheel.sh PYTHON WHEEL
set -eu
python=$1 wheel=$(realpath "$2")
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
work=$root/build/wheel/try
rm -rf "$work"
mkdir -p "$work"

say() { printf '%s\n' "$*" >&2; }

say "A fresh virtual environment: tests/python"
"$python" -m venv "$work/venv"
"$work/venv/bin/pip" install -q "$wheel" pytest pandas matplotlib rosbags mcap-ros2-support pyarrow \
  tqdm xarray casadi jax mypy submitit "dask[distributed]"
"$work/venv/bin/pip" install -q rerun-sdk || say "rerun-sdk does not install here: recordings are not tested"
cd "$root"
"$work/venv/bin/python" -m pytest -q -rs tests/python
if [ -x build/test_cli ]; then
  say "Its program: tests/cli"
  ninja -C build test_cli >&2  # one of older sources tests what was
  JACULUS_PROGRAM=$("$work/venv/bin/python" -c "from jaculus._command import program; print(program())")
  export JACULUS_PROGRAM
  build/test_cli --gtest_brief=1
else
  say "No build/test_cli: its program is not tested by tests/cli"
fi
"$work/venv/bin/python" tests/python/overhead.py

# A folder tree with Python, what Python itself links, and the wheels; no other library, no compiler.
if [ "$(id -u)" -ne 0 ]; then
  say "Not root: not tried without this system's libraries"
  exit 0
fi
say "Nothing but Python and the C library: a leap, the command"
bare=$work/bare
mkdir -p "$bare/proc" "$bare/dev" "$bare/tmp" "$bare/wheels"
"$work/venv/bin/pip" download -q --only-binary :all: -d "$bare/wheels" numpy
cp "$wheel" "$bare/wheels"
"$python" - "$bare" <<'END'
import pathlib, shutil, subprocess, sys, sysconfig
bare = pathlib.Path(sys.argv[1])
program = pathlib.Path(sys.executable).resolve()
library = pathlib.Path(sysconfig.get_path("stdlib")).resolve()
def put(path):
    path = pathlib.Path(path)
    target = bare / path.relative_to("/")
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists():
        shutil.copy2(path, target)  # a link becomes the file
put(program)
shutil.copytree(library, bare / library.relative_to("/"), symlinks=False, dirs_exist_ok=True,
                ignore=shutil.ignore_patterns("site-packages", "dist-packages", "test", "config-*", "__pycache__"))
wheels = pathlib.Path("/usr/share/python-wheels")  # Debian keeps ensurepip's apart
if wheels.is_dir():
    shutil.copytree(wheels, bare / wheels.relative_to("/"), dirs_exist_ok=True)
for file in [program, *library.glob("lib-dynload/*.so")]:
    told = subprocess.run(["ldd", file], capture_output=True, text=True, check=False).stdout
    for word in told.split():
        if word.startswith("/"):
            put(word)
# What manylinux lets a wheel expect of any system: the C and C++ runtime.
told = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=True).stdout
for name in ("libstdc++.so.6", "libgcc_s.so.1", "librt.so.1", "libpthread.so.0", "libdl.so.2", "libm.so.6", "libz.so.1"):
    put(next(line.split("=> ")[1] for line in told.splitlines() if line.split()[:1] == [name] and "x86-64" in line))
(bare / "program").write_text(str(program))
END
inside=$(cat "$bare/program")
cat > "$bare/try.py" <<'END'
import glob, resource, subprocess, sys, time
for absent in ("libipopt*", "libmujoco*", "libmumps*"):
    assert not glob.glob(f"/usr/lib/**/{absent}", recursive=True), absent
assert not glob.glob("/usr/bin/*g++*")
subprocess.run([sys.executable, "-m", "venv", "/venv"], check=True)
subprocess.run(["/venv/bin/pip", "install", "-q", "--no-index", "--find-links", "/wheels", "jaculus"], check=True)

def used():
    of = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of.ru_utime + of.ru_stime

before, start = used(), time.perf_counter()
one = "import jaculus; print(jaculus.solve('leap_tail').summary)"
told = subprocess.run(["/venv/bin/python", "-c", one], check=True, capture_output=True, text=True).stdout
took = used() - before  # of the processor, so that other programs on the machine don't count
wall = time.perf_counter() - start
print(told[:400] + f"...\nfirst answer after {wall:.1f} s, {took:.1f} s of the processor")
assert "verification: passed" in told and took < 10.0

(urdf,) = glob.glob("/venv/lib/python3*/site-packages/jaculus/share/jaculus/models/arm/robot.urdf")
for arguments in (["--version"], ["solve", "double_integrator", "--quiet", "--out", "/tmp/plan"],
                  ["simulate", "pendulum_trials", "--quiet", "--out", "/tmp/trials"],
                  ["robot", "import", urdf, "--quiet", "--out", "/tmp/arm"]):
    subprocess.run(["/venv/bin/jaculus", *arguments], check=True)
html = open("/tmp/plan/report.html").read()
assert "Charts and animation are missing" not in html
END
unshare -m sh -eu -c '
  mount -t proc proc "$1/proc"
  for node in null zero urandom random; do touch "$1/dev/$node"; mount --bind "/dev/$node" "$1/dev/$node"; done
  exec env -i HOME=/tmp LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin chroot "$1" "$2" /try.py
' sh "$bare" "$inside"
say "The wheel works"
