"""What Blender shows of a GLB: imports it as any user would and renders a picture.

    python3.11 -m venv venv && venv/bin/pip install bpy==4.5.15
    venv/bin/python benches/peers/blender.py MODEL.glb OUT.png [YAW PITCH]
"""

import math
import sys

import bpy
from mathutils import Vector


def main():
    model, out = sys.argv[1:3]
    yaw, pitch = (math.radians(float(a)) for a in (sys.argv[3:5] or ("30", "15")))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=model)
    parts = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    corners = [o.matrix_world @ Vector(c) for o in parts for c in o.bound_box]
    low = Vector(min(c[k] for c in corners) for k in range(3))
    high = Vector(max(c[k] for c in corners) for k in range(3))
    middle, radius = (low + high) / 2, (high - low).length / 2
    print(f"{len(parts)} objects, {sum(len(o.data.polygons) for o in parts)} faces, images {[i.name for i in bpy.data.images]}")

    # Blender's up is z: yaw turns about it, front looks along +y.
    away = Vector((math.sin(yaw) * math.cos(pitch), -math.cos(yaw) * math.cos(pitch), math.sin(pitch)))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + away * radius * 3.2
    camera.rotation_euler = (-away).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 50
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 3
    sun.rotation_euler = (-(away + Vector((0.5, 0, 0.8)))).to_track_quat("-Z", "Y").to_euler()
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.collection.objects.link(sun)
    scene.camera = camera
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.8, 0.8, 0.85, 1)
    world.node_tree.nodes["Background"].inputs[1].default_value = 0.7
    scene.world = world
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 16
    scene.render.resolution_x = scene.render.resolution_y = 512
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = out
    bpy.ops.render.render(write_still=True)


main()
