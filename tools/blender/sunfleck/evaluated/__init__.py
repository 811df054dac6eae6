"""Export of the evaluated scene, as Blender's own engines render it, to glTF.

A `walk` of the dependency graph, moment by moment, gives instances. `record` stores the placement and
geometry of each. `tracks` makes keys, and `thinning` drops those that interpolation gives. `shapes` finds
morph targets. `scenes` combines all, and `document` writes the file.
"""
