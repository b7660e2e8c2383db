"""Language models, small networks that reason and interpret words, for StuckSolver."""
