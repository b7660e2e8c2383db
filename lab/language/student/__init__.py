"""Trains, scores and exports the student. It requires torch."""
