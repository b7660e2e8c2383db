#!/bin/sh
# Mutation testing of the guard, with mutmut. Goes on where it was after a kill; takes up changed tests and sources.
#
#   results/mutation.sh OUT [MODULE ...]
#
# MODULE: of src/stucksolver/guard, without .py (default: those of which every mutant must be killed or named). Wants
# `mutmut` on the path, from an environment like the project's with `pip install mutmut==3.8.1`, which nothing else needs.
# OUT takes a copy of sources and tests, the session (OUT/mutants), and survivors.txt; `mutmut show MUTANT` there shows one.
#
# Each mutant runs in a fork of one warm process, against those tests only that reach its function, as one run of all tests
# without mutants has found, the quickest first, and only until one of them fails. One core. TESTS: patterns of test files
# in tests/core (default: all of the guard's).
set -eu
out=$1
shift
root=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$out/src" "$out/tests"
rm -rf "${out:?}/src/stucksolver" "${out:?}/tests/core"
cp -r "$root/src/stucksolver" "$out/src/stucksolver"
cp -r "$root/tests/core" "$out/tests/core"
rm -rf "${out:?}/benchmarks"
cp -r "$root/benchmarks" "$out/benchmarks"
{
    printf '[mutmut]\nsource_paths = src\nonly_mutate =\n'
    for module in ${*:-checks traffic aborts obstacles predict}; do
        echo "    src/stucksolver/guard/$module.py"
    done
    printf 'pytest_add_cli_args_test_selection =\n'
    for test in $(cd "$root" && ls ${TESTS:-tests/core/test_guard_*.py}); do
        case $test in
        # Not these: random examples and kept verdicts (a mutant is to be killed by a promise that says what it breaks), and
        # the policy's own.
        */test_guard_oracle.py | */test_guard_closed_loop.py | */test_guard_kept.py) [ -n "${TESTS:-}" ] && echo "    $test" ;;
        */test_guard_proofs.py | */test_guard_policy.py) ;;
        *) echo "    $test" ;;
        esac
    done
    # Nor drives that take seconds each.
    printf 'pytest_add_cli_args =\n    -p\n    no:cacheprovider\n    -k\n    not never_yields and not speeds_up\n'
    printf 'also_copy =\n    benchmarks\n'
    printf 'track_dependencies = false\nuse_git_change_detection = false\ntimeout_multiplier = 10\n'
} >"$out/setup.cfg"
cd "$out"
# MUTANTS: names of those to be run (default: all).
# shellcheck disable=SC2086
nice mutmut run --max-children 1 ${MUTANTS:-}
mutmut results >survivors.txt
mutmut export-cicd-stats
cat mutants/mutmut-cicd-stats.json
