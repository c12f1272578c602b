#!/usr/bin/env bash
# Runs the tests of the bridge to OpenVDB under valgrind: no invalid read or write, no use of what was
# not written, no bad free. Leaks are not looked for: OpenVDB keeps its registries to the end.
#
#     apt-get install valgrind
#     tests/check/memory.sh
set -euo pipefail
cd "$(dirname "$0")/../.."

tests=(vdb bad_vdb)
arguments=()
for test in "${tests[@]}"; do arguments+=(--test "$test"); done
executables=$(cargo test --no-run "${arguments[@]}" 2>&1 | sed -n 's/.*(\(target[^)]*\))$/\1/p')
[ -n "$executables" ]
for executable in $executables; do
    echo "== $executable"
    # The tests that start the program would only measure the starting.
    valgrind --quiet --error-exitcode=9 --leak-check=no --num-callers=25 --fair-sched=yes \
        "$executable" --test-threads=1 --skip every_odd_file --skip what_is_no_regular_file
done
echo "clean"
