"""An export for Mitsuba 3 as what its `load_dict` takes."""

from __future__ import annotations

import atexit
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np

from . import _native
from ._words import Path


def scene(
    export: Callable[[str, Path], dict[str, Any]], photos: list[str], photo: str | None, folder: Path | None
) -> dict[str, Any]:
    """The scene of `photo` among `photos`, whose files are written to `folder`."""
    if folder is None:
        folder = tempfile.mkdtemp(prefix="gonio-mitsuba-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    export("mitsuba", folder)
    with open(os.path.join(folder, "scenes.json"), encoding="utf-8") as file:
        scenes: dict[str, Any] = json.load(file)
    name = photos[0] if photo is None else photo
    if name not in scenes:
        raise _native.InputError(f"photo: names {name!r}, which is no photo; the photos are: {', '.join(photos)}")
    made = _made(scenes[name], os.path.abspath(folder), _transform())
    assert isinstance(made, dict)
    return made


def _transform() -> Callable[[Any], Any]:
    """What a matrix becomes."""
    mitsuba = sys.modules.get("mitsuba")
    if mitsuba is not None and mitsuba.variant() is not None:
        transform: Callable[[Any], Any] = mitsuba.ScalarTransform4f
        return transform
    return np.array


def _made(value: object, folder: str, transform: Callable[[Any], Any]) -> Any:
    if not isinstance(value, dict):
        return value
    if set(value) == {"matrix"}:
        return transform(value["matrix"])
    if set(value) == {"file"}:
        return os.path.join(folder, value["file"])
    return {key: _made(entry, folder, transform) for key, entry in value.items()}
