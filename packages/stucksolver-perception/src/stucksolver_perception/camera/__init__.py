"""Reads camera images: kinds, lamps and doors of objects, traffic lights, signs, far vehicles, and lens dirt."""
