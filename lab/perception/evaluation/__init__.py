"""Collects recordings, trains perception on them, and scores it."""
