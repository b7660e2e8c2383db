"""The camera networks: crops of what was found, and vehicles far away."""
