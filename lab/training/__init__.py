"""Trains the networks of `stucksolver_perception` on recordings. Needs torch, preferably with a GPU."""
