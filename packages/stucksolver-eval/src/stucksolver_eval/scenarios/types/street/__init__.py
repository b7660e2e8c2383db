"""Types for the streets of `demo` and `cases` on any map. Their numbers are ours."""
