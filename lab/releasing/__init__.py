"""Checks before a release: `python -m lab.releasing`, or `make release-check`. It is in no distribution."""
