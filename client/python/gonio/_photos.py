"""A capture's photographs as arrays that are read when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Scalar = TypeVar("Scalar", bound=np.generic)


class Photos(Mapping[str, NDArray[Scalar]]):
    """Arrays by a photo's name, in the capture's order. Nothing is kept: each look-up reads the photo's files."""

    def __init__(self, names: list[str], read: Callable[[str], NDArray[Scalar]]) -> None:
        self._names = names
        self._read = read

    def __getitem__(self, name: str) -> NDArray[Scalar]:
        return self._read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __repr__(self) -> str:
        return f"<photos {', '.join(self._names)}>"
