"""Mutation testing: changes one operator or bound of the product at a time, and reports which test detects it."""
