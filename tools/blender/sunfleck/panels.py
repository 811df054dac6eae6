"""Panels: render settings and fog of the scene, fog and leaf ids of objects, suns, materials."""

import bpy

from . import fog


# What is asked of a sun that shows something.
SUN_FIELDS = {
    "EVEN": (),
    "IMAGE": ("sun_image", "picture_rotation"),
    "FRACTAL": ("fractal_real", "fractal_imaginary", "fractal_iterations", "picture_rotation"),
}


MIST_FIELDS = (
    "mist_size", "mist_octaves", "mist_cover", "mist_wind", "mist_evolution_turns", "mist_shape", "mist_seed",
)


class ScenePanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_label = "sunfleck"

    def column(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = True
        return self.layout.column()


def draw_fog(column, own):
    for name in ("density", "albedo", "anisotropy"):
        column.prop(own, name)


class SUNFLECK_PT_render(ScenePanel, bpy.types.Panel):
    bl_context = "render"

    def draw(self, context):
        own, column = context.scene.sunfleck_settings, self.column()
        column.prop(own, "use_samples")
        column.prop(own, "samples" if own.use_samples else "tolerance")
        column.prop(own, "filter")
        if hasattr(context.scene, "cycles"):
            # Of the film, in a panel that Blender shows with Cycles alone.
            column.prop(context.scene.cycles, "film_exposure")
        column.prop(own, "all_bounces")
        if not own.all_bounces:
            column.prop(own, "bounces")
        column.prop(own, "seed")
        column.prop(own, "passes")
        row = self.layout.row(align=True)
        row.operator("sunfleck.render", text="Frame").animation = False
        row.operator("sunfleck.render", text="Animation").animation = True
        row.operator("sunfleck.load_frames")
        row = self.layout.row(align=True)
        row.operator("sunfleck.check")
        row.operator("sunfleck.export")


class SUNFLECK_PT_world(ScenePanel, bpy.types.Panel):
    bl_context = "world"

    def draw(self, context):
        own, column = context.scene.sunfleck_settings, self.column()
        column.prop(own, "use_world")
        if not own.use_world:
            column.prop(own, "background_color")
            column.prop(own, "background_strength")
        column.prop(own, "sky_lights")
        column.prop(own, "use_fog")
        if own.use_fog:
            draw_fog(column, own)
            column.prop(own, "scale_height")
            column.prop(own, "base_height")


class SUNFLECK_PT_object(ScenePanel, bpy.types.Panel):
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type in {"EMPTY", "MESH"}

    def draw(self, context):
        own, column = context.object.sunfleck_settings, self.column()
        column.prop(own, "is_fog")
        if own.is_fog:
            if fog.of_material(context.object):
                column.label(text="Its own volume material says how dense it is.")
            else:
                draw_fog(column, own)
            column.prop(own, "thins_out")
            if own.thins_out:
                column.prop(own, "scale_height")
            column.prop(own, "use_mist")
            for name in MIST_FIELDS if own.use_mist else ():
                column.prop(own, name)
        else:
            column.prop(own, "use_leaf_id")
            if own.use_leaf_id:
                column.prop(own, "leaf_id")


class SUNFLECK_PT_light(ScenePanel, bpy.types.Panel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type == "LIGHT" and context.object.data.type == "SUN"

    def draw(self, context):
        own, column = context.object.sunfleck_settings, self.column()
        for name in ("visible_to_camera", "limb_darkening", "sun_shows", *SUN_FIELDS[own.sun_shows]):
            column.prop(own, name)


class SUNFLECK_PT_camera(ScenePanel, bpy.types.Panel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type == "CAMERA"

    def draw(self, _context):
        self.column().label(text="Depth of field and shift are taken from above.")


class SUNFLECK_PT_material(ScenePanel, bpy.types.Panel):
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.material is not None

    def draw(self, context):
        own, column = context.material.sunfleck_settings, self.column()
        column.prop(own, "is_leaf")
        if own.is_leaf:
            column.prop(own, "translucency")
            column.prop(own, "use_transmit_color")
            if own.use_transmit_color:
                column.prop(own, "transmit_color")


CLASSES = (SUNFLECK_PT_render, SUNFLECK_PT_world, SUNFLECK_PT_object, SUNFLECK_PT_light, SUNFLECK_PT_camera, SUNFLECK_PT_material)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
