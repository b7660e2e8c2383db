"""What is done before a release: `python -m lab.releasing`, or `make release-check`. It ships with no distribution."""
