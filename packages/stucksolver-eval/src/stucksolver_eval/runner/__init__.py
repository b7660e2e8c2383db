"""Runs a suite: each route in a separate process with its own server, several in parallel."""
