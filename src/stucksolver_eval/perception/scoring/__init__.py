"""Runs perception on recordings and scores it, part by part."""
