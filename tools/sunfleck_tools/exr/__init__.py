"""EXR files of untrusted origin: headers and chunks by a parser with bounded memory, pixels by OpenEXR."""
