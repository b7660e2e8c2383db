"""Serves the student as a model with OpenAI's chat completions API."""
