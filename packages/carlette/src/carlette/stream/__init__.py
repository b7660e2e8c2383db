"""The streaming port: one connection for each stream to which a client subscribes."""
