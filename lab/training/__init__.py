"""Trains the networks of `stucksolver_perception` on recordings. It requires torch, preferably with a GPU."""
