"""Work outside the control loop: reasoners, the reader of words, and the clock that delivers their answers."""
