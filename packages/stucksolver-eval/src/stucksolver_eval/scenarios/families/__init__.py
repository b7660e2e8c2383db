"""Actions and base classes that scenario types share."""
