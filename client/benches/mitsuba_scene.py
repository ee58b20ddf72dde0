"""A capture's photo as a scene of Mitsuba 3. `peer.py` and `equal_noise.py` use it.

Materials: `lambert`, `plastic` without energy compensation, `conductor`. Lights: all kinds without a lobe. Meshes: PLY.
"""
import sys

# Columns: Mitsuba's map axes in world coordinates. Its map has +y on top and its middle column along +z; a capture's
# map has +z on top and its middle column along +x.
MAP_TO_WORLD = [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


def material(m, rgb):
    alpha = float(m.get("roughness", 0.5)) ** 2
    if m["model"] == "lambert":
        return {"type": "diffuse", "reflectance": rgb(m["base_color"])}
    if m["model"] == "plastic" and not m.get("energy_compensation"):
        return {"type": "roughplastic", "distribution": "ggx", "nonlinear": True, "alpha": alpha,
                "int_ior": float(m["ior"]), "diffuse_reflectance": rgb(m["base_color"])}
    if m["model"] == "conductor":
        return {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": rgb(m["eta"]), "k": rgb(m["k"])}
    sys.exit(f"material.{m['name']}: model {m['model']} has no peer here")


def light(mi, np, folder, l, pose, rgb):
    frame = pose if l.get("frame") == "camera" else np.eye(4)
    kind = l["kind"]
    if "lobe" in l:
        sys.exit(f"light.{l['name']}: a lobe has no peer here")
    if kind in ("point", "sphere"):
        place = (frame @ np.append(l["position"], 1))[:3].tolist()
    if kind == "point":
        return {"type": "point", "position": place, "intensity": rgb(l["intensity"])}
    if kind == "sphere":
        radiance = np.array(l["intensity"]) / (np.pi * l["radius"] ** 2)
        return {"type": "sphere", "center": place, "radius": float(l["radius"]),
                "emitter": {"type": "area", "radiance": rgb(radiance)}}
    if kind == "directional":
        return {"type": "directional", "direction": (frame[:3, :3] @ np.array(l["direction"])).tolist(),
                "irradiance": rgb(l["irradiance"])}
    if kind == "environment" and "map" in l:
        return {"type": "envmap", "filename": str(folder / l["map"]), "scale": float(l.get("scale", 1)),
                "to_world": mi.ScalarTransform4f(MAP_TO_WORLD)}
    if kind == "environment":
        return {"type": "constant", "radiance": rgb(l["radiance"])}
    sys.exit(f"light.{l['name']}: kind {kind} has no peer here")


def scene(mi, np, folder, capture, photo):
    """One photo's scene as a Mitsuba object."""
    camera = {**capture["camera"], **photo.get("camera", {})}
    pose = np.array(photo["camera_to_world"], float)
    rgb = lambda v: {"type": "rgb", "value": [float(x) for x in v]}
    width, height = camera["width"], camera["height"]
    out = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 12, "rr_depth": 6},
        "sensor": {
            "type": "perspective", "fov_axis": "x", "near_clip": 0.01, "far_clip": 100.0,
            "fov": float(np.degrees(2 * np.arctan(width / 2 / camera["fx"]))),
            "principal_point_offset_x": (width / 2 - camera["cx"]) / width,
            "principal_point_offset_y": (height / 2 - camera["cy"]) / height,
            "to_world": mi.ScalarTransform4f(pose @ np.diag([-1.0, -1.0, 1.0, 1.0])),
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": "independent"},
        },
    }
    for m in capture["material"]:
        out["material_" + m["name"]] = {**material(m, rgb), "id": "material_" + m["name"]}
    for o in capture["object"]:
        out["object_" + o["name"]] = {"type": "ply", "filename": str(folder / o["mesh"]),
                                      "to_world": mi.ScalarTransform4f(np.array(o["object_to_world"], float)),
                                      "bsdf": {"type": "ref", "id": "material_" + o["material"]}}
    for l in capture["light"]:
        if photo.get("lights") is None or l["name"] in photo["lights"]:
            out["light_" + l["name"]] = light(mi, np, folder, l, pose, rgb)
    return mi.load_dict(out)
