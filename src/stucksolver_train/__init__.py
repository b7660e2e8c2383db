"""Trains the networks of `stucksolver.perception` on recordings; needs torch, best with a GPU."""
