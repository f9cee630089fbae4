#!/bin/sh
# scripts/house must count what is planted, and find none of the worst in this tree.
# Usage: house_test.sh HOUSE TREE
set -eu
house=$1 own=$2
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
status=0
mkdir -p "$tree/src/core" "$tree/src/diagnosis/data" "$tree/src/diagnosis/verdict" "$tree/include/jaculus/model"

# A function of 20 lines without a blank line, one with; braces in strings, comments and structs are no functions.
body() { yes '  f("}{");  // }' | head -n "$1"; }
{
  printf '// Four words stand here.\n#include "jaculus/model/robot.h"\n'
  printf 'struct S { int a = static_cast<int>(b); };\nvoid dense() {\n'; body 18; printf '}\n'
  printf 'void airy() {\n'; body 9; printf '\n'; body 9; printf '}\n'
  printf 'int x = 0;  // %0120d\n' 0
} > "$tree/src/core/a.cpp"
echo '#include "diagnosis/verdict/b.h"' > "$tree/src/diagnosis/data/a.h"
printf '#include "diagnosis/data/a.h"\nbool b = verdict == "none" || answer.verdict != "effect";\n' > "$tree/src/diagnosis/verdict/b.h"
printf '#pragma once\n' > "$tree/include/jaculus/model/robot.h"
printf '#pragma once\n' > "$tree/include/jaculus/model/lonely.h"
echo 'Three plain words' > "$tree/README.md"

found=$("$house" "$tree")
expect() { printf '%s\n' "$found" | grep -qE "^$1 +$2\$" || { echo "expected '$1 $2', got:"; echo "$found"; status=1; }; }
expect 'arrows upward between modules' 1
expect 'arrows upward between the stages of diagnosis' '1 .0 files in no stage.'
expect 'arrows in circles of files, diagnosis; elsewhere' '1; 0'
expect 'static_casts to integer types' 1
expect 'lines over 100 columns' '1 of .*'
expect 'functions of 20 lines or more without a blank line' '1 of 2 .*'
expect 'lengths of functions: median, 95th percentile, longest' '20, 20, 21'
expect 'words a comment line' 4.0
expect 'public headers; of no other module; not reached' '2; 1; 1'
expect 'comparisons of a verdict with a string' 2
expect 'words of README.md' 3

found=$("$house" "$own")
expect 'arrows upward between modules' 0
expect 'arrows upward between the stages of diagnosis' '0 .*'
expect 'lines over 100 columns' '0 of .*'
expect 'comparisons of a verdict with a string' 0
exit $status
