"""What takes time, off the control loop: reasoners, the reader of words, and the clock that delivers their answers."""
