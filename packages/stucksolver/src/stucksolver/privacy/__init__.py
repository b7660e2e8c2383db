"""Keeps logins out of texts, and files to their owner. Imports nothing but the standard library."""
