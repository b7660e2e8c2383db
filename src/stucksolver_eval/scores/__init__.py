"""From the records of routes to scores, tables and comparisons."""
