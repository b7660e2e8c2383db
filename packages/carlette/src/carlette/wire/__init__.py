"""The wire formats of the protocol: arrays for msgpack, packed structs for the streams."""
