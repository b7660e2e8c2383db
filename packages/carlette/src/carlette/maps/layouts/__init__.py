"""The plans of the maps that ship."""
