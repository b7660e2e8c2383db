"""Bench2Drive's 44 scenario types, one file each."""
