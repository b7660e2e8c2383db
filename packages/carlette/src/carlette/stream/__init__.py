"""The streaming port: one connection for each stream that a client subscribed to."""
