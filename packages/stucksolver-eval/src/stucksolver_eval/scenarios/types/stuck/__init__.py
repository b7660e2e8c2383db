"""Stuck situations that the public types lack, and controls in which waiting is right."""
