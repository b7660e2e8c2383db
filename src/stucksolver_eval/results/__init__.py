"""What a run leaves: manifest, outcome and record of each route, and where they lie."""
