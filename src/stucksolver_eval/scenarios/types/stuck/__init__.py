"""Stuck situations that the public types lack, and controls in which doing nothing is right."""
