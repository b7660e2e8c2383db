"""Recordings of drives with the truth beside them, and the scores of perception on them."""
