"""Captures: what was photographed, and what is known of it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from . import _farm, _mitsuba, _native
from ._farm import Farm
from ._photos import Photos
from ._results import Diagnosis, Fit
from ._words import Path, call, words

Progress = Callable[[str], object]
"""Hears a line of progress, such as `print` does."""


class Buffers(NamedTuple):
    """A render and what the camera's rays hit first. H rows, W columns, the top row first."""

    image: NDArray[np.float32]
    """H x W x 3: photo values, as in the photo's own file."""
    depth: NDArray[np.float32]
    """H x W: metres along the camera's z axis; 0 where nothing is hit."""
    normals: NDArray[np.float32]
    """H x W x 3: unit vectors in world coordinates; 0 where nothing is hit."""
    objects: NDArray[np.int32]
    """H x W: index in `Capture.objects`; -1 where nothing is hit."""
    positions: NDArray[np.float32]
    """H x W x 3: metres, in world coordinates."""
    half_angles: NDArray[np.float32]
    """H x W: radians between the normal and the half vector of view and first lamp; 0 where there is none."""
    incidence_angles: NDArray[np.float32]
    """H x W: radians between the normal and the view."""


class Capture:
    """A capture: photographs of a part, with cameras, meshes, materials and lights.

    Numbers have dotted names, as `gonio check --names` lists them: `capture["material.shell.roughness"]` gives one,
    `capture["material.shell.base_color"]` an array of those below that name. Assigning changes the capture in memory; no file is
    written before `save`. Lengths are metres, angles radians, light is linear RGB.

    Work goes to `farm`: that of this process unless a `Farm` or a URL is given. It releases the interpreter's lock; Ctrl-C
    ends it within a second, and raises KeyboardInterrupt.
    """

    def __init__(self, native: _native.Capture, farm: Farm | None = None) -> None:
        self._native = native
        self.farm = farm

    @property
    def name(self) -> str:
        """What capture.toml calls it."""
        return self._native.name

    @property
    def names(self) -> list[str]:
        """Dotted names of all numbers, sorted."""
        return list(self._native.numbers())

    @property
    def numbers(self) -> dict[str, float]:
        """Every number by dotted name. A copy: assign to the capture itself to change one."""
        return {name: value for name, (value, _, _) in self._native.numbers().items()}

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Least and largest value that every number may have."""
        return {name: (low, high) for name, (_, low, high) in self._native.numbers().items()}

    @property
    def free(self) -> list[str]:
        """Names that `fit` frees unless it is told others: those of `[fit]` in capture.toml."""
        return self._native.free[0]

    @property
    def objects(self) -> list[str]:
        """The objects' names, in the order of `Buffers.objects`."""
        return self._native.objects

    @property
    def photos(self) -> Photos[np.float32]:
        """Photo values by the photo's name: float32, H x W x 3, as in its file, the top row first. Read when looked up."""
        return Photos([name for name, _ in self._native.photos], lambda name: self._native.photo(name)[0])

    @property
    def masks(self) -> Photos[np.bool_]:
        """Which pixels count, by the photo's name: bool, H x W; inside of the photo's mask, and not clipped."""
        return Photos([name for name, _ in self._native.photos], lambda name: self._native.photo(name)[1])

    @property
    def held_out(self) -> list[str]:
        """Names of the photos that nothing is fitted to."""
        return [name for name, held_out in self._native.photos if held_out]

    def __getitem__(self, name: str) -> float | NDArray[np.float64]:
        """The number of that name, or an array of all numbers right below it, such as a colour's red, green and blue."""
        numbers = self.numbers
        if name in numbers:
            return numbers[name]
        below = self._below(name, numbers)
        if not below:
            # The command line's own words for a name that is none.
            self._native.set_numbers([(name, 0.0)])
        return np.array([numbers[one] for one in below])

    def __setitem__(self, name: str, value: float | Sequence[float] | NDArray[Any]) -> None:
        """Sets the number of that name, or all numbers right below it: to a value each, or all to the same.

        Raises InputError for a name that is none, and for a value outside of its bounds.
        """
        numbers = self.numbers
        below = [] if name in numbers else self._below(name, numbers)
        if not below:
            self._native.set_numbers([(name, _one(name, value))])
            return
        values = np.asarray(value, dtype=np.float64).ravel()
        if values.size == 1:
            values = np.repeat(values, len(below))
        if values.size != len(below):
            raise _native.InputError(f"{name}: is given {values.size} values; it is {len(below)} numbers")
        self._native.set_numbers([(one, float(entry)) for one, entry in zip(below, values, strict=True)])

    def __contains__(self, name: object) -> bool:
        """Whether there is a number of that name, or are numbers right below it."""
        numbers = self.numbers
        return isinstance(name, str) and (name in numbers or bool(self._below(name, numbers)))

    @staticmethod
    def _below(name: str, numbers: Mapping[str, float]) -> list[str]:
        found = [one for one in numbers if one.startswith(f"{name}.") and "." not in one[len(name) + 1 :]]
        # Colours are red, green, blue, and lists count; both are sorted by name above.
        order = {"r": 0, "g": 1, "b": 2}
        last = [one.rsplit(".", 1)[1] for one in found]
        if set(last) <= set(order):
            found.sort(key=lambda one: order[one.rsplit(".", 1)[1]])
        elif all(part.isdigit() for part in last):
            found.sort(key=lambda one: int(one.rsplit(".", 1)[1]))
        return found

    def update(self, values: Mapping[str, float]) -> None:
        """Sets many numbers by dotted name: all of them, or none where one is refused."""
        self._native.set_numbers([(name, float(value)) for name, value in values.items()])

    def copy(self) -> Capture:
        """Another capture with the same content; changing one leaves the other as it is."""
        return Capture(self._native.copy(), self.farm)

    def to_toml(self) -> str:
        """What capture.toml would say in the capture's own folder."""
        return self._native.text()

    def save(self, folder: Path) -> None:
        """Writes capture.toml to `folder`, made where it is missing. It leads to the meshes and photos where they lie."""
        self._native.save(folder)

    @overload
    def render(
        self,
        photos: str,
        *,
        samples: int = ...,
        seed: int = ...,
        buffers: Literal[False] = ...,
        progress: Progress | None = ...,
        farm: Farm | str | None = ...,
    ) -> NDArray[np.float32]: ...
    @overload
    def render(
        self,
        photos: str,
        *,
        samples: int = ...,
        seed: int = ...,
        buffers: Literal[True],
        progress: Progress | None = ...,
        farm: Farm | str | None = ...,
    ) -> Buffers: ...
    @overload
    def render(
        self,
        photos: list[str] | tuple[str, ...] | None = ...,
        *,
        samples: int = ...,
        seed: int = ...,
        buffers: Literal[False] = ...,
        progress: Progress | None = ...,
        farm: Farm | str | None = ...,
    ) -> dict[str, NDArray[np.float32]]: ...
    @overload
    def render(
        self,
        photos: list[str] | tuple[str, ...] | None = ...,
        *,
        samples: int = ...,
        seed: int = ...,
        buffers: Literal[True],
        progress: Progress | None = ...,
        farm: Farm | str | None = ...,
    ) -> dict[str, Buffers]: ...
    def render(
        self,
        photos: str | list[str] | tuple[str, ...] | None = None,
        *,
        samples: int = 64,
        seed: int = 0,
        buffers: bool = False,
        progress: Progress | None = None,
        farm: Farm | str | None = None,
    ) -> NDArray[np.float32] | Buffers | dict[str, NDArray[np.float32]] | dict[str, Buffers]:
        """Renders photos: float32, H x W x 3, photo values, the top row first; bit for bit what `gonio render` writes.

        A name gives its array; names, or none for all photos, give a dictionary by name. `samples` per pixel are even: half of
        them go to each of two independent halves. With `buffers`, first hits come with each render (`Buffers`).
        """
        names = [photos] if isinstance(photos, str) else list(photos or [])
        given = words(samples=samples, seed=seed, buffers=buffers)
        rendered = _native.render(self._native, self._farm(farm), names, given, progress)
        if not buffers:
            images = {name: image for name, image, _ in rendered}
            return images[photos] if isinstance(photos, str) else images
        hits = {name: _buffers(image, planes or []) for name, image, planes in rendered}
        return hits[photos] if isinstance(photos, str) else hits

    def fit(
        self,
        *,
        samples: int = 64,
        seed: int = 0,
        solver: str | None = None,
        pixels: int | Literal["all"] | None = None,
        accuracy: float | None = None,
        start: Mapping[str, float] | None = None,
        free: Iterable[str] | None = None,
        gray: Iterable[str] | None = None,
        max_iterations: int | None = None,
        progress: Progress | None = None,
        farm: Farm | str | None = None,
    ) -> Fit:
        """Fits the free numbers to the photographs; the same numbers as `gonio fit` writes. This capture stays as it is.

        samples: most samples per pixel of any iteration, even. solver: "gauss-newton", "nelder-mead", "l-bfgs" or
        "particle-swarm". pixels: how many are compared, or "all"; as many as are needed where it is None. accuracy: relative
        standard error wanted of every number. start: other values to start from. free: dotted names to free instead of those of
        the capture. gray: colours among them that keep their ratio. progress hears the lines that the command prints.

        Raises InputError for a capture or an option that makes no fit, GonioError where the farm fails.
        """
        options = dict(
            samples=samples,
            seed=seed,
            solver=solver,
            pixels=pixels,
            accuracy=accuracy,
            start=dict(start) if start else None,
            free=list(free) if free is not None else None,
            gray=list(gray) if gray is not None else None,
            max_iterations=max_iterations,
        )
        said = call("Capture.fit", **options)
        native = _native.fit(self._native, self._farm(farm), words(**options), progress, said)
        return Fit(native, Capture(native.capture(), self.farm))

    def diagnose(
        self,
        *,
        samples: int = 64,
        seed: int = 0,
        smallest_gain: float | None = None,
        smallest_file_gain: float | None = None,
        without: Iterable[str] | None = None,
        progress: Progress | None = None,
        farm: Farm | str | None = None,
    ) -> Diagnosis:
        """Names what the simulation of this capture gets wrong, as `gonio diagnose` does. This capture stays as it is.

        samples: most samples per pixel of any fit's iteration, even. smallest_gain: smallest gain of interest, as a part of
        chi-square above the noise floor; 0.02 where it is None. smallest_file_gain: the same of measured reflectance, as a part of
        the error; 0.1. without: effects to leave out, such as "defocus".
        """
        options = dict(
            samples=samples,
            seed=seed,
            smallest_gain=smallest_gain,
            smallest_file_gain=smallest_file_gain,
            without=list(without) if without is not None else None,
        )
        said = call("Capture.diagnose", **options)
        native = _native.diagnose(self._native, self._farm(farm), words(**options), progress, said)
        return Diagnosis(native, Capture(native.capture(), self.farm))

    def export(self, to: str, folder: Path) -> dict[str, Any]:
        """Writes the scene for another program to `folder`: `to` is "mitsuba", "blender", "usd", "gltf" or "pbrt".

        Gives what export.json holds: which numbers were kept exactly, approximated, and how, or lost.
        """
        record: dict[str, Any] = json.loads(_native.export(self._native, to, folder))
        return record

    def to_mitsuba(self, photo: str | None = None, folder: Path | None = None) -> dict[str, Any]:
        """The scene of a photo, the first where none is named, as a dictionary for `mitsuba.load_dict`.

        Meshes and maps are written to `folder`, or to one that is removed when Python ends. Matrices are Mitsuba's
        `ScalarTransform4f` where Mitsuba is imported and has a variant, and arrays of 4 x 4 elsewhere.
        """
        return _mitsuba.scene(self.export, [name for name, _ in self._native.photos], photo, folder)

    def _farm(self, farm: Farm | str | None) -> _native.Farm:
        return _farm.native(self.farm if farm is None else farm)

    def __repr__(self) -> str:
        photos, numbers = self._native.photos, self._native.numbers()
        return f"<capture {self.name!r}: {len(photos)} photos, {len(numbers)} numbers, {len(self.free)} names free>"


def load(path: Path, *, farm: Farm | str | None = None) -> Capture:
    """The capture at `path`: its folder, or the capture.toml inside. Work on it goes to `farm`.

    Raises InputError where there is none, or where its text is not the format; the error names file, key and mend.
    """
    return Capture(_native.load(path), Farm(farm) if isinstance(farm, str) else farm)


def _one(name: str, value: float | Sequence[float] | NDArray[Any]) -> float:
    values = np.asarray(value, dtype=np.float64)
    if values.size != 1:
        raise _native.InputError(f"{name}: is given {values.size} values; it is one number")
    return float(values.ravel()[0])


def _buffers(image: NDArray[np.float32], planes: list[NDArray[np.float32]]) -> Buffers:
    depth, nx, ny, nz, objects, x, y, z, half, incidence = planes
    return Buffers(
        image=image,
        depth=depth,
        normals=np.stack([nx, ny, nz], axis=-1),
        objects=objects.astype(np.int32),
        positions=np.stack([x, y, z], axis=-1),
        half_angles=half,
        incidence_angles=incidence,
    )
