"""Driving stacks that the solver is fitted to."""
