"""Drives routes and scores them: suites, scenarios, criteria, scores and reports.

Uses only the product's public API.
"""
