"""Builds the documentation site: `python -m docsite` or `make docs`. Not part of any distribution."""
