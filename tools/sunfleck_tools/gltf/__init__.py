"""glTF 2.0 as `sunfleck export` and Blender write it, read and written with json and numpy alone."""
