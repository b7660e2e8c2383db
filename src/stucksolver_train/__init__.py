"""Trains the networks of `stucksolver.perception` on recordings. Needs torch, preferably with a GPU."""
