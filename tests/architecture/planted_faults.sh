#!/bin/sh
# The checker of include arrows must pass a clean tree and find each planted fault. Usage: planted_faults.sh CHECKER
set -eu
checker=$1
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
status=0

clean() {
  rm -rf "$tree/src" "$tree/include"
  mkdir -p "$tree/src/core" "$tree/src/solver" "$tree/src/dynamics" "$tree/include/jaculus/model"
  echo '#include <vector>' > "$tree/src/core/a.cpp"
  echo '#include "jaculus/core/error.h"' > "$tree/include/jaculus/model/robot.h"
  printf '#include "jaculus/model/robot.h"\n#include "jaculus/core/types.h"\n' > "$tree/src/dynamics/a.cpp"
  printf '#include <IpTNLP.hpp>\n#include "jaculus/core/types.h"\n#include "terms.h"\n' > "$tree/src/solver/ipopt.cpp"
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
yes '//' | head -n 401 | expect 'src/core/b.cpp:401: longer than 400 lines' src/core/b.cpp
exit $status
