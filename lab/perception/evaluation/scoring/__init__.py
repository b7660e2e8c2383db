"""Runs perception on recordings and scores each part separately."""
