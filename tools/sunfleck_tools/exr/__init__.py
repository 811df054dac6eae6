"""EXR files, read with suspicion: headers and chunks by own code of bounded memory, pixels by OpenEXR."""
