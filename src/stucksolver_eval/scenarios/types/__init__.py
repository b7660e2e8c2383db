"""One file for each situation; importing a file registers its types."""
