# Shared by the scripts beside it: what jaculus needs on Debian, and how it is built. Sourced by
# POSIX sh; sets `root`.

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)

# package - why
build_packages='
g++ - compiles C++20
cmake - configures the build
ninja-build - runs the build
pkg-config - finds Ipopt
libeigen3-dev - matrices and vectors
coinor-libipopt-dev - the interior-point solver, with MUMPS
liblapack-dev - Ipopt links it
libblas-dev - Ipopt links it
liburdfdom-dev - reads robots from URDF
libyaml-cpp-dev - reads problem and robot files
libcli11-dev - the command line
libfmt-dev - text and numbers that read back exactly
nlohmann-json3-dev - JSON results
libtbb-dev - runs independent solves on all cores
libboost-dev - the integrator that verifies plans and runs the plant (odeint)
libboost-filesystem-dev - what runs xacro (process) needs it
libmuparser-dev - formulas of effects in files
libsodium-dev - seals the labels of test cases
libmujoco-dev - the independent engine of the testbed
python3-matplotlib - figures for papers
'
test_packages='
libgtest-dev - the tests
chromium - opens reports in the browser test
'
format_packages='
clang-format - the one formatting of the code
'
tidy_packages='
clang-tidy - static checks
'
fuzz_packages='
clang - compiles the fuzzers
libclang-rt-14-dev - libFuzzer and its sanitizers
'
benchmark_packages='
libbenchmark-dev - the benchmarks
'
site_packages='
doxygen - the C++ reference of the site
'
python_packages='
python3-dev - the Python module
python3-venv - pip and its environments
'

# Charts of reports come from npm. Node's own packages bring npm along, Debian's don't, so programs
# are asked for, not packages.
web_packages='
nodejs - runs the bundler of reports
npm - fetches the charts of reports
'

say() { printf '%s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

# ensure_packages TABLE...: installs what is missing of the tables, having said what and why; one
# quick query where nothing is.
ensure_packages() {
  table=$(printf '%s\n' "$@" | sed '/^$/d')
  wanted=$(printf '%s\n' "$table" | sed 's/ - .*//')
  if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
    say "This is no Debian: nothing is installed. Needed are the counterparts of:" $wanted
    return 0
  fi
  present=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' $wanted 2>/dev/null | sed -n 's/^installed //p')
  missing=
  for package in $wanted; do
    printf '%s\n' "$present" | grep -qxF "$package" || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  say "These packages are missing and will be installed with apt:"
  for package in $missing; do printf '%s\n' "$table" | grep -F "$package - " | grep "^$package - " | sed 's/^/  /' >&2; done
  install_packages $missing
}

# ensure_web: node and npm, from wherever they are.
ensure_web() {
  if command -v node >/dev/null 2>&1 && command -v npm >/dev/null 2>&1; then return 0; fi
  ensure_packages "$web_packages"
}

install_packages() {
  as_root=
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || fail "Neither root nor sudo is at hand. Have an administrator run: apt-get install $*"
    as_root='sudo'
  fi
  apt="$as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300"
  # The package lists are fetched only where they lack a package or turn out to be stale.
  if apt-cache show $* >/dev/null 2>&1 && $apt install -y --no-install-recommends "$@" >&2; then return 0; fi
  $apt update >&2 || fail "apt-get update failed: is there a network, and a mirror in the apt sources?"
  $apt install -y --no-install-recommends "$@" >&2 || fail "apt-get could not install: $*"
}

# ensure_bindings: sets `bindings_python`, a Python with what the bindings and their short test need;
# false where PyPI can't be reached.
ensure_bindings() {
  bindings_python=$root/build/bindings_tools/bin/python
  "$bindings_python" -c "import nanobind, numpy, pytest" 2>/dev/null && return 0
  say "nanobind, numpy and pytest are fetched from PyPI for the Python package"
  if python3 -m venv "$root/build/bindings_tools" >&2 &&
    timeout 180 "$bindings_python" -m pip install -q --retries 1 --timeout 30 'nanobind>=2.4,<4' \
      numpy pytest >&2; then return 0; fi
  say "PyPI can't be reached: the Python package is NEITHER BUILT NOR TESTED"
  return 1
}

# configure PRESET [CMAKE_OPTION...]: sets up the build folder of CMakePresets.json.
configure() {
  mkdir -p "$root/build"
  log=$root/build/configure_$1.log
  (cd "$root" && cmake --preset "$@") >"$log" 2>&1 && return 0
  cat "$log" >&2
  fail "the configuration failed"
}

# build_release [CMAKE_OPTION...]: the one build of users and tests, in build/; $targets says what,
# everything by default. A new folder is set up without tests. Once they are on they stay, for CMake
# deletes what it no longer builds.
build_release() {
  [ -e "$root/build/CMakeCache.txt" ] || set -- -DJACULUS_TESTS=OFF "$@"
  configure release -DJACULUS_WERROR="${JACULUS_WERROR:-OFF}" "$@"
  ninja -C "$root/build" ${targets:-} >&2 || fail "the build failed"
}

cores() { nproc 2>/dev/null || echo 1; }
