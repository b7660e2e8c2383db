"""Finds places on maps for scenarios: lanes, junctions and ramps with what a type needs."""
