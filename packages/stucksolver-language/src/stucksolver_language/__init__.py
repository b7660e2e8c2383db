"""Language models that reason, and a small network that interprets utterances, for StuckSolver."""
