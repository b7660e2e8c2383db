"""Removes from an interpretation what the utterance denies, forbids or warns of. It never adds a permission."""
