"""The scenes of this export as objects of Mitsuba 3.

    import mitsuba as mi
    mi.set_variant("scalar_rgb")              # or another one of RGB
    import scene
    image = mi.render(scene.load("00"), spp=256)
    scene.names()                             # the photos

`description(photo)` gives what `mi.load_dict` takes, to be changed first.
"""
import json
import os

import mitsuba as mi

FOLDER = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(FOLDER, "scenes.json"), encoding="utf-8") as file:
    SCENES = json.load(file)


def names():
    """The photos' names, sorted."""
    return sorted(SCENES)


def description(photo):
    """The scene of a photo as a dictionary for `mi.load_dict`."""
    return _made(SCENES[photo])


def load(photo):
    """The scene of a photo."""
    return mi.load_dict(description(photo))


def _made(value):
    if not isinstance(value, dict):
        return value
    if set(value) == {"matrix"}:
        return mi.ScalarTransform4f(value["matrix"])
    if set(value) == {"file"}:
        return os.path.join(FOLDER, value["file"])
    return {key: _made(entry) for key, entry in value.items()}
