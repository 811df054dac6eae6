"""The evaluated scene, which is what Blender's own engines render, as a glTF file.

A `walk` of the dependency graph, moment by moment, gives instances. `record` keeps where each of them is and
which geometry it shows. `tracks` makes keys of that, and `thinning` leaves out those that straight lines
give. `shapes` says how meshes bend. `scenes` puts all of it together and `document` writes it.
"""
