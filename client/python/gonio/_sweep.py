"""Sweeps: a capture at many values of its numbers, from many views."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _farm, _native
from ._farm import Farm
from ._words import Path, words


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of a sweep."""

    index: int
    """Its row in the sweep's table."""
    point: int
    """Which point of the design it renders."""
    view: str
    """The photo, or the view that the sweep's file names."""
    values: dict[str, float]
    """The numbers that vary, by dotted name."""
    digest: str
    """What its files are called by."""
    mean: tuple[float, float, float]
    """Mean photo value of red, green and blue."""
    image: NDArray[np.float32] | None
    """H x W x 3: photo values, the top row first. None for a frame that lay in `out` before, without its "exr"."""


def sweep(
    path: Path,
    *,
    out: Path | None = None,
    without: Iterable[str] | None = None,
    diagnosis: Path | None = None,
    in_flight: int | None = None,
    progress: Callable[[str], object] | None = None,
    farm: Farm | str | None = None,
) -> Iterator[Frame]:
    """Renders the frames of a sweep's file and gives each as it is finished, in whatever order that is.

    With `out`, a folder or s3://BUCKET/PREFIX, frames and tables are kept there as `gonio sweep` keeps them, frames that are
    there come first, and others alone are rendered. without: effects of the diagnosis.json `diagnosis` to render without.
    in_flight: evaluations under way at once. Leaving the loop ends the sweep; what was finished stays in `out`.
    """
    given = [word for effect in without or [] for word in words(without=effect)]
    given += words(diagnosis=diagnosis, in_flight=in_flight)
    native = _native.Sweep(path, None if out is None else str(out), _farm.native(farm), given, progress)
    try:
        while (frame := native.next()) is not None:
            index, point, view, numbers, digest, (red, green, blue), image = frame
            yield Frame(index, point, view, dict(numbers), digest, (red, green, blue), image)
    finally:
        native.close()
