"""What this distribution adds to the `stucksolver` program."""
