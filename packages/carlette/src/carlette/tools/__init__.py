"""Tools beside the server: they draw the pictures of the documentation."""
