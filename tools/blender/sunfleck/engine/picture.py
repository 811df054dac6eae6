"""Frames of the program as pixels of Blender's Render Result."""

import bpy
import numpy

from . import cryptomatte, passes
from .exporting import NotRendered


class Picture:
    """Frame: rows from the top, columns, channels by name; and the manifest of its Cryptomatte, if it has
    one."""

    def __init__(self, names, pixels, manifest=None):
        self.numbers, self.pixels = {name: number for number, name in enumerate(names)}, pixels
        self.manifest = manifest

    def of(self, channels):
        """Pixels in Blender's order, rows from the bottom; None if the frame lacks a channel."""
        if not channels or not set(channels) <= self.numbers.keys():
            return None
        numbers = [self.numbers[channel] for channel in channels]
        # Adjacent channels are copied twice as fast.
        beside = slice(numbers[0], numbers[0] + len(numbers))
        are_beside = numbers == list(range(beside.start, beside.stop))
        found = self.pixels[::-1, :, beside if are_beside else numbers]
        return numpy.ascontiguousarray(found, "f4").ravel()


def read(path):
    """Reads a frame with Blender's own library."""
    bpy.utils.expose_bundled_modules()
    import OpenImageIO

    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        raise NotRendered(f"{path} cannot be read: {OpenImageIO.geterror()}")
    try:
        pixels = file.read_image(OpenImageIO.FLOAT)
        if pixels is None:
            raise NotRendered(f"{path} cannot be read: {file.geterror()}")
        said = {one.name: one.value for one in file.spec().extra_attribs}
        manifests = [value for name, value in said.items() if cryptomatte.is_manifest(name)]
        return Picture(file.spec().channelnames, pixels, next(iter(manifests), None))
    finally:
        file.close()


def show(engine, layer, picture):
    """Shows an intermediate picture."""
    result = filled(engine, layer, picture)
    engine.update_result(result)
    # Blender has copied it, and more will come.
    engine.end_result(result, cancel=True)


def hand_over(engine, layer, picture):
    engine.end_result(filled(engine, layer, picture))
    if picture.manifest is not None:
        # Metadata of the whole result, as those of parts are not kept.
        whole = engine.get_result()
        for name, value in cryptomatte.metadata(f"{layer}.CryptoObject", picture.manifest):
            whole.stamp_data_add_field(name, value)


def filled(engine, layer, picture):
    """Blender's result with the passes of a picture."""
    rows, columns = picture.pixels.shape[:2]
    result = engine.begin_result(0, 0, columns, rows, layer=layer)
    for one in result.layers[0].passes:
        found = picture.of(passes.channels_of(one.name, one.channels))
        if found is not None:
            if found.size != len(one.rect) * one.channels:
                engine.end_result(result, cancel=True)
                raise NotRendered(f"the picture has {columns} x {rows} pixels, and Blender's has {len(one.rect)}")
            signs = passes.signs(one.name)
            if signs:
                found = (found.reshape(-1, len(signs)) * numpy.array(signs, "f4")).ravel()
            one.rect.foreach_set(found)
    return result
