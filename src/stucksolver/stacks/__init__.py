"""Driving stacks with the solver attached."""
