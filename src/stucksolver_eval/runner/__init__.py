"""Runs a suite: each route in a process of its own with a server of its own, several at a time."""
