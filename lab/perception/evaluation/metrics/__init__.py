"""Metrics of perception: pure functions on arrays, one metric per file."""
