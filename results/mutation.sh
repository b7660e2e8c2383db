#!/bin/sh
# Mutation testing of the guard, with mutmut. Resumes after an interruption; picks up changed tests and sources.
#
#   results/mutation.sh OUT [MODULE ...]
#
# MODULE: in src/stucksolver/guard, without .py (default: those of which every mutant must be killed or listed). `mutmut`
# must be on the path, from an environment like the project's with `pip install mutmut==3.8.1`; nothing else needs it.
# OUT gets a copy of sources and tests, the session (OUT/mutants), and survivors.txt; `mutmut show MUTANT` there shows one.
#
# Each mutant runs in a fork of one warm process, only against the tests that reach its function (from one run of all tests
# without mutants), fastest first, until one of them fails. It uses one core. TESTS: patterns of test files in tests/core
# (default: all of the guard's).
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
        # Excluded: random examples and stored verdicts, because a mutant should be killed by a test that says what it
        # breaks, and the tests of the policy.
        */test_guard_oracle.py | */test_guard_oracle_excuses.py | */test_guard_closed_loop.py | */test_guard_kept.py) [ -n "${TESTS:-}" ] && echo "    $test" ;;
        */test_guard_proofs.py | */test_guard_policy.py) ;;
        *) echo "    $test" ;;
        esac
    done
    # Also excluded: drives that take seconds each.
    printf 'pytest_add_cli_args =\n    -p\n    no:cacheprovider\n    -k\n    not never_yields and not speeds_up\n'
    printf 'also_copy =\n    benchmarks\n'
    printf 'track_dependencies = false\nuse_git_change_detection = false\ntimeout_multiplier = 10\n'
} >"$out/setup.cfg"
cd "$out"
# MUTANTS: names of the mutants to run (default: all).
# shellcheck disable=SC2086
nice mutmut run --max-children 1 ${MUTANTS:-}
mutmut results >survivors.txt
mutmut export-cicd-stats
cat mutants/mutmut-cicd-stats.json
