"""Builds the documentation's web site: `python -m docsite`, or `make docs`. It ships with no distribution."""
