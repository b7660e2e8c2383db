"""Computes scores, tables and comparisons from the records of routes."""
