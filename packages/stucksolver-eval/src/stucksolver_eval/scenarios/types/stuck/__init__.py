"""Immobilizing situations that the public types lack, and controls in which waiting is right.

Their numbers are ours.
"""
