#!/bin/sh
# Runs the drives that results/*.md report. Resumes after an interruption.
#
#   results/run.sh bench220|dev|immobilized|immobilized-now|guided|sweep|wrong|wrong220|sensors|heedless|latency OUT
#
# `stucksolver` must be on the path; OUT gets one folder for each arm. `guided` and `latency` need the Python of the
# project's environment on the path.
set -eu
part=$1 out=$2
mkdir -p "$out"

arm() {
    name=$1
    shift
    echo "== $part: $name"
    # The table reports routes that fail to run; the other arms continue.
    stucksolver evaluate --out "$out/$name" --resume --replays none "$@" >"$out/$name.txt" 2>"$out/$name.log" ||
        tail -n 3 "$out/$name.log"
}

four_arms() {
    arm alone --recovery none "$@"
    arm timers --recovery timers "$@"
    arm search --recovery search "$@"
    arm guided --recovery search --guidance shipped --reuse "$out/search" "$@"
}

planner_arms() {
    arm planner-alone --driver planner --recovery none "$@"
    arm planner-timers --driver planner --recovery timers "$@"
    arm planner-search --driver planner --recovery search "$@"
}

late_arms() {
    arm search-late --recovery search --clock latency:2.8 "$@"
    arm guided-late --recovery search --guidance shipped --clock latency:2.8 --reuse "$out/search-late" "$@"
}

wrong() {
    arm "$1-$2" --suite "$1" --recovery "faulty:$2"
    [ "$2" = silent ] || arm "$1-$2-unguarded" --suite "$1" --recovery "faulty:$2" --unguarded
}

case $part in
bench220 | immobilized-now)
    four_arms --suite "${part%-now}"
    planner_arms --suite "${part%-now}"
    ;;
dev | immobilized)
    four_arms --suite "$part" --seeds 1,2,3
    late_arms --suite "$part" --seeds 1,2,3
    ;;
guided)
    # Only the routes with words; on the others both arms are the same.
    for suite in bench220 immobilized dev; do
        words=$(dirname "$0")/../packages/stucksolver-eval/src/stucksolver_eval/suites/data/guidance-$suite.json
        routes=$(python -c 'import json, sys; print(*sorted(json.load(open(sys.argv[1]))["routes"]), sep=",")' "$words")
        arm "$suite-search" --suite "$suite" --seeds 1,2,3 --routes "$routes" --recovery search
        arm "$suite-guided" --suite "$suite" --seeds 1,2,3 --routes "$routes" --recovery search --guidance shipped
    done
    ;;
sweep) arm dev --suite dev --recovery search --sweep v_min=2,5,10,20 --sweep dt=0.5,1,3,10 ;;
wrong)
    for suite in dev immobilized; do
        arm "$suite-alone" --suite "$suite" --recovery none
        for who in random always_left always_drive_over silent late; do wrong "$suite" "$who"; done
    done
    ;;
sensors)
    # Some four times as slow as with the ground truth.
    for suite in dev immobilized bench220; do
        arm "$suite-search" --suite "$suite" --recovery search --perception sensors
    done
    arm bench220-alone --suite bench220 --recovery none --perception sensors --reuse "$out/bench220-search"
    ;;
heedless)
    # With and without the driver's own braking on a plan's path; `types` is one route of each type of immobilized.
    types=$(seq -s, 3000 10 3240)
    for braking in "" -heedless; do
        for who in random late always_drive_over always_left; do
            arm "dev-$who$braking" --suite dev --recovery "faulty:$who" ${braking:+--heedless}
        done
        arm "dev-search$braking" --suite dev --recovery search ${braking:+--heedless}
        arm "types-random$braking" --suite immobilized --routes "$types" --recovery faulty:random ${braking:+--heedless}
        arm "types-search$braking" --suite immobilized --routes "$types" --recovery search ${braking:+--heedless}
    done
    ;;
wrong220)
    arm bench220-alone --suite bench220 --recovery none
    wrong bench220 "${3:?give the worst reasoner}"
    ;;
latency)
    hasty=$out/hasty.toml
    python -c 'from stucksolver.ladder import profile_text; print(profile_text("evaluation"), end="")' |
        sed 's/^deadline_s = 10.0/deadline_s = 5.0/' >"$hasty"
    python "$(dirname "$0")/../packages/stucksolver-language/tests/llm/chat_server.py" --port 8077 &
    server=$!
    trap 'kill $server' EXIT
    model="openai:reader@http://127.0.0.1:8077/v1"
    arm alone --suite dev --recovery none
    for seconds in 0 1 2.8 6; do
        arm "latency-$seconds" --suite dev --recovery "$model" --clock "latency:$seconds" --ladder "$hasty"
    done
    arm latency-6-patient --suite dev --recovery "$model" --clock latency:6
    ;;
*)
    echo "unknown part $part" >&2
    exit 2
    ;;
esac
