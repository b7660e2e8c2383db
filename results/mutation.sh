#!/bin/sh
# Mutation testing of the guard, with mutmut. Goes on where it was after a kill; takes up changed tests and sources.
#
#   results/mutation.sh OUT [MUTANT ...]
#
# Wants Python to be that of the project's environment with `pip install mutmut==3.8.1`, which nothing else needs. OUT takes
# a copy of the sources and tests, the session (OUT/mutants), and survivors.txt. Each mutant runs in a fork of one warm
# process, against those tests only that reach its function, as one run of all tests without mutants has found, and only
# until the first of them fails. One core. MUTANT: names or patterns, to look at these again.
set -eu
out=$1
shift
root=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$out"
for part in src tests; do
    rm -rf "${out:?}/$part"
    cp -r "$root/$part" "$out/$part"
done
# Left out are randomized tests (the oracle, the proofs), since a mutant must be killed by a promise that says what it
# breaks, and drives of the whole solver, each of which takes seconds.
for test in "$out"/tests/core/test_*.py; do
    case $(basename "$test") in
    test_guard_oracle.py | test_guard_proofs.py | test_guard_policy.py) rm "$test" ;;
    test_guard_*.py) ;;
    *) rm "$test" ;;
    esac
done
cat >"$out/setup.cfg" <<'CFG'
[mutmut]
source_paths = src
only_mutate =
    src/stucksolver/guard/checks.py
    src/stucksolver/guard/traffic.py
    src/stucksolver/guard/aborts.py
    src/stucksolver/guard/obstacles.py
    src/stucksolver/guard/predict.py
pytest_add_cli_args_test_selection =
    tests/core
pytest_add_cli_args =
    -p
    no:cacheprovider
    -k
    not never_yields and not speeds_up
track_dependencies = false
use_git_change_detection = false
timeout_multiplier = 10
CFG
cd "$out"
nice mutmut run --max-children 1 "$@"
mutmut results >survivors.txt
mutmut export-cicd-stats
cat mutants/mutmut-cicd-stats.json
