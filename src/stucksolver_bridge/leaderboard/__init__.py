"""The entry for CARLA's leaderboard and Bench2Drive: hand `stucksolver_entry.py` to the evaluator as `--agent`."""
