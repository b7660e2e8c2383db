"""The solver as a state machine: frozen states, a tick's inputs, and the pure function from one to the next."""
