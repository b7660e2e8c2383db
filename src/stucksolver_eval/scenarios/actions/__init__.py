"""Moves that scenarios share."""
