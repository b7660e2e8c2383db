"""How things move and touch."""
