"""Trains, scores and exports the student. Needs torch."""
