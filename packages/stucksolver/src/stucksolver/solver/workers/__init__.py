"""Work outside the control loop: reasoners, the interpreter, and the clock that delivers their answers."""
