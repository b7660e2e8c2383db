"""Types for the streets that `demo` and `cases` find on any map."""
