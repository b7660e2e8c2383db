"""The request port: msgpack-rpc and the methods that a client can call."""
