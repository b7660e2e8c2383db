"""Finds sites on any map where an obstacle can immobilize a vehicle, and routes past them."""
