"""Names that meshes and materials share."""


def texture_coordinates(layer: int) -> str:
    """The name of a set of texture coordinates."""
    return "st" if layer == 0 else f"st{layer}"
