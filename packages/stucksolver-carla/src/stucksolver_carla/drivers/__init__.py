"""The two base drivers."""
