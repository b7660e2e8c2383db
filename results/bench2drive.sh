#!/bin/sh
# Runs Bench2Drive's unmodified evaluator with the entry of stucksolver_bridge. Resumes after an interruption.
#
#   results/bench2drive.sh alone|timers|search|guided|blind|sensors-alone|sensors-search SEED OUT
#
# `guided` copies the routes on which nobody says anything from `search`, if that has been driven. `sensors-*` drive with
# our own planner.
#
# Each route is a separate run, so that a route that hangs affects no other. Environment:
#
#   BENCH2DRIVE   a checkout of Bench2Drive 0.0.4
#   CARLA_AGENTS  the folder that holds CARLA's `agents`
#   CARLA_ROOT    a CARLA installation, or the folder that `carlette --as-carla-root` wrote
#   EVALUATOR     Python 3.8 with carla 0.9.15 and what the leaderboard requires
#   SOLVER        Python 3.10 to 3.12 with stucksolver
#   ROUTES        route ids (default: those of Town01, Town02, Town04 and Town10HD)
#   PORT          port of the simulator (2000); the TrafficManager's is 6000 higher. Parallel runs need ports 10 apart
#   GPU_RANK      the GPU on which CARLA renders (0). After a crash the evaluator kills all simulators of the same rank,
#                 so parallel runs need different ranks; carlette uses no GPU, and its rank defaults to the port
#   ROUTES_FILE   another file of routes in leaderboard/data (bench2drive220); ROUTES must then name routes in it
set -eu
arm=$1 seed=$2
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$3/$arm-$seed"
out=$(cd "$3/$arm-$seed" && pwd)
port=${PORT:-2000}
grep -qs carlette "$CARLA_ROOT/CarlaUE4.sh" && : "${GPU_RANK:=$port}"
: "${ROUTES:=24211 24224 24240 24294 24330 24340 24781 24784 24785 24795 24841 25300 25951 26406 26944 27494 27529 28035
28048 28087 28093 28099 28111 28154}"
entry=$("$SOLVER" -c 'import stucksolver_bridge.leaderboard as b; print(b.__path__[0])')/stucksolver_entry.py

case $arm in
alone) config='"recovery": "none"' ;;
blind) config='"recovery": "none", "obstacles": false' ;;
timers) config='"recovery": "timers"' ;;
search) config='"recovery": "search"' ;;
guided) config="\"recovery\": \"search\", \"guidance\": \"$here/bench2drive-guidance.json\"" ;;
sensors-alone) config='"recovery": "none"' ;;
sensors-search) config='"recovery": "search"' ;;
*)
    echo "unknown arm $arm" >&2
    exit 2
    ;;
esac
limit_s=1200
case $arm in
sensors-*)
    config="$config, \"perception\": \"sensors\", \"driver\": \"planner\""
    limit_s=3600
    ;;
# Nothing uses the camera and the LiDAR here, and they would take most of the time.
*) config="$config, \"sensors\": false" ;;
esac
# If nobody speaks, guidance changes nothing: the run without it is used for both.
silent=
if [ "$arm" = guided ]; then silent=search; fi
echo "{$config, \"python\": \"$SOLVER\", \"events\": \"$out/events\", \"record\": \"$out/record\"}" >"$out/config"

code=$BENCH2DRIVE/leaderboard:$BENCH2DRIVE/scenario_runner
export CARLA_ROOT IS_BENCH2DRIVE=True SAVE_PATH="$out/metrics" PYTHONPATH="$CARLA_AGENTS:$code"
export LEADERBOARD_ROOT="$BENCH2DRIVE/leaderboard" SCENARIO_RUNNER_ROOT="$BENCH2DRIVE/scenario_runner"
mkdir -p "$out/records" "$out/logs"
cd "$BENCH2DRIVE"
for route in $ROUTES; do
    file=$out/records/$route.json
    # Routes that crashed are driven again.
    grep -s '"status": "\(Completed\|Failed\|Perfect\)' "$file" | grep -qv crashed && continue
    rm -f "$file"
    same=$out/../$silent-$seed/records/$route.json
    if [ -n "$silent" ] && ! grep -q "\"$route\"" "$here/bench2drive-guidance.json" && [ -s "$same" ]; then
        cp "$same" "$file"
        continue
    fi
    timeout "$limit_s" "$EVALUATOR" leaderboard/leaderboard/leaderboard_evaluator.py \
        --routes "leaderboard/data/${ROUTES_FILE:-bench2drive220}.xml" --routes-subset "$route" --repetitions 1 --track SENSORS \
        --checkpoint "$file" --agent "$entry" --agent-config "$out/config" \
        --port "$port" --gpu-rank "${GPU_RANK:-0}" --traffic-manager-port $((port + 6000)) --traffic-manager-seed "$seed" \
        >"$out/logs/$route.log" 2>&1 || echo "route $route: $(tail -n 1 "$out/logs/$route.log")"
    echo "$(date +%T) $arm $seed $route $(grep -o '"status": "[^"]*"' "$file" | tail -n 1)"
done
