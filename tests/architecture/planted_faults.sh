#!/bin/sh
# The checker of include arrows must pass a clean tree and find each planted fault. Usage:
# planted_faults.sh CHECKER
set -eu
checker=$1
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
status=0

clean() {
  rm -rf "$tree/src" "$tree/include"
  mkdir -p "$tree/src/core" "$tree/src/solver" "$tree/src/dynamics" "$tree/include/jaculus/model" "$tree/src/diagnosis/verdict" \
    "$tree/src/report/render"
  echo '#include <vector>' > "$tree/src/core/a.cpp"
  echo '#include "jaculus/core/error.h"' > "$tree/include/jaculus/model/robot.h"
  printf '#include "jaculus/model/robot.h"\n#include "jaculus/core/types.h"\n' > "$tree/src/dynamics/a.cpp"
  printf '#include <IpTNLP.hpp>\n#include "jaculus/core/types.h"\n#include "terms.h"\n' > "$tree/src/solver/ipopt.cpp"
  printf '#include "diagnosis/data/segments.h"\n#include "diagnosis/settings.h"\n' > "$tree/src/diagnosis/verdict/a.cpp"
  printf '#include "report/document/html.h"\n#include "jaculus/report/report.h"\n' > "$tree/src/report/render/page.cpp"
}

expect() {  # expect MESSAGE FILE: with FILE's new text from standard input, the checker fails with MESSAGE
  clean
  mkdir -p "$(dirname "$tree/$2")"
  cat > "$tree/$2"
  if output=$("$checker" "$tree"); then
    echo "not found: $1 in $2"; status=1
  elif ! printf '%s\n' "$output" | grep -qF "$1"; then
    echo "expected '$1', got '$output'"; status=1
  fi
}

clean
"$checker" "$tree" || { echo "a clean tree was refused"; status=1; }
echo '#include "jaculus/model/robot.h"' | expect 'src/core/b.cpp:1: core may not include model' src/core/b.cpp
echo '#include "solver/private.h"' | expect 'src/dynamics/b.cpp:1: dynamics may not include solver' src/dynamics/b.cpp
echo '#include "jaculus/solver/ipopt.h"' | expect 'model/b.h:1: model may not include solver' include/jaculus/model/b.h
echo '#include <IpTNLP.hpp>' | expect 'only src/solver/ipopt* may include Ipopt' src/solver/solve.cpp
echo '#include <coin-or/IpTNLP.hpp>' | expect 'only src/solver/ipopt* may include Ipopt' src/solver/solve.cpp
echo '#include <coin/IpTNLP.hpp>' | expect 'only src/solver/ipopt* may include Ipopt' src/core/b.cpp
echo '#include "jaculus/nowhere/a.h"' | expect 'there is no module nowhere' src/core/b.cpp
echo '// new' | expect 'module gadgets is not in the table' src/gadgets/a.cpp
echo '#include "diagnosis/verdict/rules.h"' |
  expect 'data/b.cpp:1: the step data of diagnosis may not include verdict' src/diagnosis/data/b.cpp
echo '#include "jaculus/diagnosis/localise/where.h"' |
  expect 'noise/b.h:1: the step noise of diagnosis may not include localise' include/jaculus/diagnosis/noise/b.h
echo '#include "jaculus/diagnosis/diagnose.h"' | expect 'may not include diagnose.h' src/diagnosis/data/b.cpp
echo '#include "diagnosis/build_problem.h"' | expect 'may not include build_problem.h' src/diagnosis/data/b.cpp
echo '// new' | expect 'step guesswork of diagnosis is not in the list' src/diagnosis/guesswork/a.cpp
echo '#include "simulation/integrate/run.h"' |
  expect 'contact/b.cpp:1: the step contact of simulation may not include integrate' src/simulation/contact/b.cpp
echo '#include "jaculus/simulation/experiment.h"' |
  expect 'the step plant of simulation may not include experiment.h' src/simulation/plant/b.cpp
echo '// new' | expect 'step gadgets of simulation is not in the list' src/simulation/gadgets/a.cpp
echo '#include "report/render/stick_figure.h"' |
  expect 'document/a.h:1: the step document of report may not include render' src/report/document/a.h
echo '#include "report/plan_parts.h"' |
  expect 'the step render of report may not include the builder plan_parts.h' src/report/render/a.cpp
echo '#include "jaculus/export/export.h"' |
  expect 'solver/b.cpp:1: solver may not include export' src/solver/b.cpp
yes '//' | head -n 401 | expect 'src/core/b.cpp:401: longer than 400 lines' src/core/b.cpp
exit $status
