"""Tables of situations from public reports: what is staged, its source, and the right reaction.

The staging and its numbers are ours. A source is the publication with its date; "common report" names a family of
reports where no single one is meant.
"""
