"""Contains the two built-in drivers."""
