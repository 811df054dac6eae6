"""Valid files that the program does not support, by their unsupported feature.

Invariant: any other file is supported or damaged.
"""

from .header import COMPRESSIONS, HeaderError, parse_headers

UNREAD = {
    "htj2k256": "HTJ2K (htj2k256)", "htj2k32": "HTJ2K (htj2k32)", "lj2k": "lossy JPEG 2000 (lj2k)", "zstd": "Zstandard (zstd)",
}  # fmt: skip
HOW = "`oiiotool IN.exr {} -o OUT.exr` does (`pip install OpenImageIO`)"
ZIP, FLAT = HOW.format("-a --compression zip"), HOW.format("--flatten --compression zip")

CUBE = b"\1"
UNFOLD = "`exrenvmap -latlong IN.exr OUT.exr` of OpenEXR's own tools does"


def why_unread(data: bytes) -> str | None:
    """Sentence with a remedy if the renderer does not support an EXR file; None if it does, if the file is
    not EXR, or if that is unknown."""
    try:
        headers = parse_headers(data)
    except HeaderError:
        return None
    if any(header.is_deep for header in headers):
        return f"deep data cannot be read: flatten it: {FLAT}"
    if headers[0].values.get("envmap") == CUBE:
        return f"it shows the six sides of a cube (`envmap`): unfold it by longitude and latitude: {UNFOLD}"
    for header in headers:
        if (name := UNREAD.get(COMPRESSIONS[header.compression])) is not None:
            return f"the compression {name} cannot be read: save it with ZIP compression: {ZIP}"
    return None
