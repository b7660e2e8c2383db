"""The files of a run: manifest, and outcome and record of each route."""
