"""Keeps logins out of texts, and files private to their owner. Imports only the standard library."""
