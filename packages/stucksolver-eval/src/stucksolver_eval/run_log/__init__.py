"""Records the replay of a drive, which a page can show."""
