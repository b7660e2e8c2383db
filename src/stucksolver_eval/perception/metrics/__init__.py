"""Scores of perception: pure functions on arrays, one metric a file."""
