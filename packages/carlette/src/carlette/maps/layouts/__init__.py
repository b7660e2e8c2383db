"""The plans of the shipped maps."""
