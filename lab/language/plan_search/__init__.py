"""Finds good plans for standstills by search and exact drives: the teacher of a distilled model, and its data."""
