"""Tools besides the server: they draw the pictures of the documentation."""
