"""Materials. In go node trees, out come glTF materials.

`sockets` follows a socket to its source, `principled` reads a Principled BSDF, `images` adds pictures to
the file and `library` numbers materials for meshes. Other trees are baked (`bake`).
"""
