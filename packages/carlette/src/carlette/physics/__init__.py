"""Motion and contacts."""
