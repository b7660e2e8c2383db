"""The simulated world: steppable in-process, free of sockets."""
