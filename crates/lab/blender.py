"""Draws docs/pictures/blender.png: models, and below each the hulls that were written back into its file.

    pip install bpy
    for model in chair lamp mug teapot dog; do hullwright bake --into=ucx assets/$model.glb -o written; done
    python crates/lab/blender.py written docs/pictures/blender.png
"""

import sys

import bpy
from mathutils import Matrix, Vector

MODELS = ("chair", "lamp", "mug", "teapot", "dog")
# In lengths of a model's diagonal, which is one in the picture.
APART, BELOW = 0.9, 1.0


def bounds(objects):
    points = [o.matrix_world @ Vector(corner) for o in objects for corner in o.bound_box]
    return tuple(Vector([pick(p[axis] for p in points) for axis in range(3)]) for pick in (min, max))


def add(path, x):
    known = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=path)
    bpy.context.view_layer.update()
    meshes = [o for o in bpy.data.objects if o not in known and o.type == "MESH"]
    low, high = bounds([o for o in meshes if not o.name.startswith("UCX_")])
    for o in meshes:
        z = -BELOW if o.name.startswith("UCX_") else 0
        place = Matrix.Translation((x, 0, z)) @ Matrix.Scale(1 / (high - low).length, 4)
        world = place @ Matrix.Translation(-(low + high) / 2) @ o.matrix_world
        o.parent = None
        o.matrix_world = world
    return meshes


def main(folder, picture):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    meshes = [o for k, model in enumerate(MODELS) for o in add(f"{folder}/{model}.glb", APART * k)]
    bpy.context.view_layer.update()
    middle = sum(bounds(meshes), Vector()) / 2
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.lens = 56
    camera.location = middle + Vector((1.2, -7, 1.8))
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3, (0.6, 0.3, 0.4)
    for o in (camera, sun):
        scene.collection.objects.link(o)
    scene.camera, scene.world = camera, bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky[0].default_value, sky[1].default_value = (0.85, 0.85, 0.87, 1), 0.7
    scene.render.engine, scene.cycles.samples = "CYCLES", 48
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 1000, 500
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


main(*sys.argv[-2:])
