#!/bin/sh
# The runner of documentation must pass a sound page and find each planted fault.
# Usage: planted_faults.sh PYTHON RUNNER
set -eu
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
status=0
mkdir -p "$tree/models" "$tree/problems" "$tree/docs"
printf '#!/bin/sh\necho "v/T base 6.770 m/s^2 (at $1)"\n' > "$tree/jaculus"
chmod +x "$tree/jaculus"

python=$1 runner=$2
page() {
  "$python" "$runner" "$tree/page.md" --program "$tree/jaculus" --source "$tree" \
    --work "$tree/work" 2>&1
}

expect() {  # expect MESSAGE: with the page from standard input the runner fails with MESSAGE
  cat > "$tree/page.md"
  if output=$(page); then
    echo "not found: $1"; status=1
  elif ! printf '%s\n' "$output" | grep -qF "$1"; then
    echo "expected '$1', got '$output'"; status=1
  fi
}

fence='```'
cat > "$tree/page.md" <<END
${fence}yaml
# made/here.yaml
a: 1
${fence}
${fence}sh run
test -f made/here.yaml
jaculus solve
${fence}
${fence}text prints
  v/T base    6.7704 m/s^2
  (at solve)
${fence}
${fence}sh exits 3
exit 3
${fence}
${fence}sh run needs data
false
${fence}
${fence}text prints
of a block that was not run
${fence}
${fence}sh not run: long
false
${fence}
END
printf '%s\n' "${fence}cpp from code.cpp" 'int a;' "$fence" >> "$tree/page.md"
printf 'int b;\nint a;\n' > "$tree/code.cpp"
page >/dev/null || { echo "a sound page was refused"; page || true; status=1; }

printf '%s\n' "${fence}sh run" 'false' "$fence" | expect 'ended with 1 instead of 0'
printf '%s\n' "${fence}sh run" 'false' 'true' "$fence" | expect 'ended with 1 instead of 0'
printf '%s\n' "${fence}sh exits 1" 'true' "$fence" | expect 'ended with 0 instead of 1'
printf '%s\n' "${fence}sh" 'true' "$fence" | expect "page.md:1: an sh block is marked"
printf '%s\n' "${fence}sh run" 'jaculus' "$fence" "${fence}text prints" 'v/T base 7.1' "$fence" |
  expect "page.md:4: 'v/T base 7.1' is not in what was printed"
printf '%s\n' "${fence}cpp from code.cpp" 'int c;' "$fence" |
  expect 'page.md:1: this does not stand in code.cpp as it is'
printf '%s\n' "${fence}sh run" 'true' | expect 'page.md:1: this block is never closed'

printf '[a](docs/there.md) [b](docs/nowhere.md)\n' > "$tree/README.md"
: > "$tree/docs/there.md"
output=$("$python" "$runner" --links --source "$tree" 2>&1) &&
  { echo "a dead link was not found"; status=1; }
printf '%s\n' "$output" | grep -q 'nowhere.md, which is not there' ||
  { echo "got '$output'"; status=1; }
seq 1000 > "$tree/README.md"
output=$("$python" "$runner" --links --source "$tree" 2>&1) &&
  { echo "a long README was not found"; status=1; }
exit $status
