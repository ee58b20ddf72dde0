"""A photo's scene in Blender 4 or 5, by Cycles.

    blender --background --python scene.py -- --photo 00 --out 00.exr [--samples 256] [--save 00.blend]

or, in Blender's own Python or with the module `bpy`: `import scene; scene.build("00"); scene.render("00.exr", 256)`. The picture
holds linear radiance; photograph() of sensor.py makes the photo's values of it.
"""
import argparse
import json
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix

FOLDER = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(FOLDER, "scene.json"), encoding="utf-8") as file:
    SCENE = json.load(file)


def names():
    """The photos' names, sorted."""
    return sorted(SCENE["photos"])


def build(photo):
    """Replaces everything that is open by the scene of a photo."""
    view = SCENE["photos"][photo]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.unit_settings.scale_length = 1.0
    materials = [material(m) for m in SCENE["materials"]]
    for part in SCENE["objects"]:
        add(part["name"], mesh(part), part["to_world"]).data.materials.append(materials[part["material"]])
    for number, one in enumerate(view["lamps"]):
        lamp(f"lamp {number}", one)
    world(view)
    camera(view)
    settings(view)


def render(path, samples=256, seed=0):
    """Renders the scene that is open to an OpenEXR file of 32-bit floats."""
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def settings(view):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = view["width"], view["height"]
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    # Nothing is clamped, blurred or left out to make a picture quieter.
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 32
    # The mean over a pixel's square.
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0


def camera(view):
    scene = bpy.context.scene
    data = bpy.data.cameras.new("camera")
    width, height, fx, fy = view["width"], view["height"], view["fx"], view["fy"]
    data.sensor_fit, data.sensor_width = "HORIZONTAL", 36.0
    data.lens = fx * 36.0 / width
    data.shift_x = (0.5 * width - view["cx"]) / width
    data.shift_y = (view["cy"] - 0.5 * height) / fy * fx / width
    data.clip_start, data.clip_end = 0.001, 10000.0
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(1.0, fy / fx), max(1.0, fx / fy)
    if view["aperture_radius"] > 0:
        data.dof.use_dof, data.dof.focus_distance = True, view["focus_distance"]
        data.dof.aperture_fstop = data.lens * 1e-3 / (2 * view["aperture_radius"])
    # Blender's camera looks along -z with y up.
    pose = np.array(view["camera_to_world"]) @ np.diag([1.0, -1.0, -1.0, 1.0])
    scene.camera = add("camera", data, pose)


def add(name, data, to_world):
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = Matrix([list(map(float, row)) for row in to_world])
    bpy.context.scene.collection.objects.link(thing)
    if hasattr(thing, "shadow_terminator_geometry_offset"):
        thing.shadow_terminator_geometry_offset = thing.shadow_terminator_shading_offset = 0.0
    return thing


def mesh(part):
    columns, triangles = read_ply(os.path.join(FOLDER, part["mesh"]))
    points, normals = columns["x", "y", "z"], columns["nx", "ny", "nz"]
    data = bpy.data.meshes.new(part["name"])
    data.from_pydata(points.tolist(), [], triangles.tolist())
    smooth = normals is not None
    data.polygons.foreach_set("use_smooth", np.full(len(triangles), smooth))
    if smooth:
        if hasattr(data, "use_auto_smooth"):  # Before Blender 4.1.
            data.use_auto_smooth = True
        data.normals_split_custom_set_from_vertices(normals.tolist())
    corners = np.empty(len(data.loops), int)
    data.loops.foreach_get("vertex_index", corners)
    if columns["u", "v"] is not None:
        data.uv_layers.new(name="UVMap").data.foreach_set("uv", columns["u", "v"][corners].ravel())
    if columns["r", "g", "b"] is not None:
        colours = np.ones((len(points), 4), np.float32)
        colours[:, :3] = columns["r", "g", "b"]
        data.color_attributes.new("Color", "FLOAT_COLOR", "POINT").data.foreach_set("color", colours.ravel())
    return data


def read_ply(path):
    """Columns by their names, None where they are not there, and triangles of a file as this export writes it."""
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    vertices, faces = (int(line[2]) for line in lines if line[0] == "element")
    names = [line[2] for line in lines if line[:2] == ["property", "float"]]
    table = np.frombuffer(body, "<f4", vertices * len(names)).reshape(vertices, len(names))
    groups = [("x", "y", "z"), ("nx", "ny", "nz"), ("u", "v"), ("r", "g", "b")]
    columns = {group: table[:, [names.index(name) for name in group]] if group[0] in names else None for group in groups}
    rest = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<u4", 3)]), faces, vertices * len(names) * 4)
    return columns, rest["v"]


def lamp(name, one):
    brightest = max(one["rgb"])
    kind = "SUN" if one["kind"] == "directional" else "POINT"
    data = bpy.data.lights.new(name, kind)
    data.color = [channel / brightest for channel in one["rgb"]]
    place = np.eye(4)
    if kind == "SUN":
        # Irradiance on a plane that faces it; it shines along its -z.
        data.energy, data.angle = brightest, 0.0
        place[:3, :3] = np.array(one["turn"])
    else:
        # A lamp of P watts sends P / (4 pi) per solid angle.
        data.energy, data.shadow_soft_size = 4 * math.pi * brightest, one["radius"]
        if hasattr(data, "use_soft_falloff"):
            data.use_soft_falloff = False
        place[:3, 3] = one["position"]
    add(name, data, place)


def world(view):
    made = bpy.data.worlds.new("world")
    bpy.context.scene.world = made
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    out = nodes.new("ShaderNodeOutputWorld")
    constant = nodes.new("ShaderNodeBackground")
    constant.inputs["Color"].default_value = (*view["constant"], 1.0)
    constant.inputs["Strength"].default_value = 1.0
    shader = constant
    if view["map"] is not None:
        sky = nodes.new("ShaderNodeBackground")
        sky.inputs["Strength"].default_value = view["map"]["scale"]
        image = nodes.new("ShaderNodeTexEnvironment")
        image.image = bpy.data.images.load(os.path.join(FOLDER, view["map"]["file"]))
        image.image.colorspace_settings.name = "Non-Color"
        place, mapping = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
        to_map = Matrix([row[:3] for row in view["map"]["to_world"][:3]]).transposed()
        mapping.inputs["Rotation"].default_value = to_map.to_euler("XYZ")
        links.new(place.outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], image.inputs["Vector"])
        links.new(image.outputs["Color"], sky.inputs["Color"])
        shader = nodes.new("ShaderNodeAddShader")
        links.new(constant.outputs[0], shader.inputs[0])
        links.new(sky.outputs[0], shader.inputs[1])
    links.new(shader.outputs[0], out.inputs["Surface"])


def material(one):
    made = bpy.data.materials.new(one["name"])
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader = {"lambert": lambert, "plastic": plastic, "conductor": conductor}[one["model"]](tree, one)
    # Gonio's surfaces are black from behind.
    side, black, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "BsdfDiffuse", "MixShader"))
    black.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    tree.links.new(side.outputs["Backfacing"], mix.inputs[0])
    tree.links.new(shader.outputs[0], mix.inputs[1])
    tree.links.new(black.outputs[0], mix.inputs[2])
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(mix.outputs[0], out.inputs["Surface"])
    return made


def lambert(tree, one):
    if one["sheen"] is not None or one["scatter_distance"] > 0:
        return principled(tree, one, one["lobes"][0], level=0.0)
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*one["lobes"][0]["color"], 1.0)
    vary(tree, one, "Base Color", node.inputs["Color"])
    node.inputs["Roughness"].default_value = min(1.0, one["diffuse_roughness"])
    return node


def plastic(tree, one):
    first = principled(tree, one, one["lobes"][0])
    if len(one["lobes"]) == 1:
        return first
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = one["lobes"][1]["weight"]
    tree.links.new(first.outputs[0], mix.inputs[1])
    tree.links.new(principled(tree, one, one["lobes"][1]).outputs[0], mix.inputs[2])
    return mix


def principled(tree, one, lobe, level=0.5):
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    node.distribution = "MULTI_GGX" if one["energy_compensation"] else "GGX"
    put = node.inputs
    put["Base Color"].default_value = (*lobe["color"], 1.0)
    put["Roughness"].default_value = lobe["roughness"]
    put["IOR"].default_value = one["ior"]
    put["Specular IOR Level"].default_value = level
    put["Metallic"].default_value = one["metallic"]
    put["Anisotropic"].default_value = lobe["anisotropic"]
    put["Anisotropic Rotation"].default_value = one["anisotropic_rotation"]
    vary(tree, one, "Base Color", put["Base Color"])
    vary(tree, one, "Metallic", put["Metallic"])
    if lobe is one["lobes"][0]:
        vary(tree, one, "Roughness", put["Roughness"])
    if lobe["anisotropic"] > 0:
        tangent(tree, put["Tangent"])
    if "Diffuse Roughness" in put:  # From Blender 4.3.
        put["Diffuse Roughness"].default_value = min(1.0, one["diffuse_roughness"])
    if one["coat"] is not None:
        put["Coat Weight"].default_value = one["coat"]["factor"]
        put["Coat Roughness"].default_value = one["coat"]["roughness"]
        put["Coat IOR"].default_value = one["coat"]["ior"]
    if one["sheen"] is not None:
        put["Sheen Weight"].default_value = 1.0
        put["Sheen Roughness"].default_value = one["sheen"]["roughness"]
        put["Sheen Tint"].default_value = (*one["sheen"]["color"], 1.0)
    if one["scatter_distance"] > 0:
        node.subsurface_method = "BURLEY"
        put["Subsurface Weight"].default_value = 1.0
        put["Subsurface Radius"].default_value = (1.0, 1.0, 1.0)
        put["Subsurface Scale"].default_value = one["scatter_distance"]
    return node


def conductor(tree, one):
    lobe = one["lobes"][0]
    if hasattr(bpy.types, "ShaderNodeBsdfMetallic"):  # From Blender 4.3.
        node = tree.nodes.new("ShaderNodeBsdfMetallic")
        node.distribution, node.fresnel_type = "GGX", "PHYSICAL_CONDUCTOR"
        node.inputs["IOR"].default_value, node.inputs["Extinction"].default_value = one["eta"], one["k"]
        node.inputs["Anisotropy"].default_value = lobe["anisotropic"]
        node.inputs["Rotation"].default_value = one["anisotropic_rotation"]
    else:
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.distribution = "GGX"
        node.inputs["Base Color"].default_value = (*one["metal_color"], 1.0)
        node.inputs["Metallic"].default_value = 1.0
        node.inputs["Anisotropic"].default_value = lobe["anisotropic"]
        node.inputs["Anisotropic Rotation"].default_value = one["anisotropic_rotation"]
    node.inputs["Roughness"].default_value = lobe["roughness"]
    vary(tree, one, "Roughness", node.inputs["Roughness"])
    if lobe["anisotropic"] > 0:
        tangent(tree, node.inputs["Tangent"])
    return node


def vary(tree, one, socket, into):
    """Puts the map of a number, if it has one, into a node's input."""
    if socket not in one["maps"]:
        return
    map = one["maps"][socket]
    if map["file"] is None:
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "Color"
    else:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.load(os.path.join(FOLDER, map["file"]), check_existing=True)
        node.image.colorspace_settings.name = "Non-Color"
        node.extension = map["extension"]
    tree.links.new(node.outputs["Color"], into)


def tangent(tree, into):
    node = tree.nodes.new("ShaderNodeTangent")
    node.direction_type, node.axis = "RADIAL", "Z"
    tree.links.new(node.outputs[0], into)


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    ask = argparse.ArgumentParser(prog="scene.py")
    ask.add_argument("--photo", choices=names(), default=names()[0])
    ask.add_argument("--out", help="OpenEXR file to render to")
    ask.add_argument("--samples", type=int, default=256)
    ask.add_argument("--save", help="Blender file to save the scene to")
    given = ask.parse_args(words)
    build(given.photo)
    if given.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(given.save))
    if given.out:
        render(given.out, given.samples)
