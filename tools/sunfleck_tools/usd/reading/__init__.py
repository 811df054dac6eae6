"""USD stages to glTF that sunfleck renders."""
