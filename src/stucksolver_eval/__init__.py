"""Drives routes and judges them: suites, scenarios, criteria, scores and reports. It needs the product's faces only."""
