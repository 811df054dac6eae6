"""Import of USD stages as glTF."""
