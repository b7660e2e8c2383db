"""The solver as a state machine: frozen states, the inputs of a tick, and a pure transition function."""
