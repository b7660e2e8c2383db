"""Finds places on any map where a vehicle can get stuck behind something, and routes past them."""
