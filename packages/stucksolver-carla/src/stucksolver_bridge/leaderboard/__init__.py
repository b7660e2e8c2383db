"""The entry for CARLA's leaderboard and Bench2Drive: pass `stucksolver_entry.py` to the evaluator as `--agent`."""
