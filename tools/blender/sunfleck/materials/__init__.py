"""Materials by what they look like: node trees in, glTF materials out.

`sockets` follows a socket to what gives its value, `principled` reads a Principled BSDF, `images`
brings pictures into the file and `library` numbers materials for meshes. What is no Principled
BSDF is baked (`bake`).
"""
