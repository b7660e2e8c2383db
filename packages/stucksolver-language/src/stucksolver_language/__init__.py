"""Language models and small networks that reason and interpret utterances for StuckSolver."""
