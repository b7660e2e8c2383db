"""How the reader of a passenger's words is made: the grammar of its sentences, its training, its export."""
