"""Records the replay of a run for a page."""
