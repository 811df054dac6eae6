"""Drawing of pictures in a region of Blender's window."""

import gpu
from gpu_extras.presets import draw_texture_2d


class Drawn:
    """Keeps the GPU texture of the shown picture."""

    def __init__(self):
        self.number, self.texture = 0, None

    def draw(self, engine, scene, viewport, size):
        """Draws the last picture, scaled to the region, in the scene's display space."""
        if viewport.shown is None:
            return
        if self.number != viewport.number:
            rows, columns = viewport.shown.pixels.shape[:2]
            pixels = viewport.shown.of("RGBA")
            buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels)
            self.texture = gpu.types.GPUTexture((columns, rows), format="RGBA16F", data=buffer)
            self.number = viewport.number
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self.texture, (0, 0), *size)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
