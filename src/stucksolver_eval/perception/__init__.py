"""Collecting recordings, training on them, and the scores of perception."""
