"""Builds the documentation site: `python -m lab.docsite` or `make docs`. Not part of any distribution."""
