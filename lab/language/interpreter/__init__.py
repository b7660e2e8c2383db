"""Tools for the interpreter of a passenger's utterances: the grammar of its sentences, its training, its export."""
