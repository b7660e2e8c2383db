"""One file per situation; importing a file registers its types."""
