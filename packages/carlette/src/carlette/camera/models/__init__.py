"""The models of things: vehicles, people, animals, props, signs and lights, as meshes."""
