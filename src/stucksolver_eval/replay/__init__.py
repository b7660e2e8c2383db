"""What is kept of a drive, so that a page can show it again."""
