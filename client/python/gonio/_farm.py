"""Where captures are evaluated."""

from __future__ import annotations

from . import _native
from ._words import Path, words


class Farm:
    """Render threads of this process, or a render farm behind a URL.

    Without a URL the farm is embedded: `threads` render threads of this process, 0 for one on each core. With one, such as
    "https://host:7300", it is the coordinator there; `token`, `ca`, `cert` and `key` are the files that it asks for (the README's
    "More than one machine" makes them). The environment variables of the command line, such as GONIO_FARM and GONIO_CA, count
    where an argument is absent.

    Raises InputError for an address or a file that cannot be used, GonioError where nobody answers.
    """

    def __init__(
        self,
        url: str | None = None,
        *,
        threads: int = 0,
        token: Path | None = None,
        ca: Path | None = None,
        cert: Path | None = None,
        key: Path | None = None,
    ) -> None:
        given = words(farm=url, threads=threads or None, token=token, ca=ca, cert=cert, key=key)
        self._native = _native.Farm(given)
        self._url = url

    def __repr__(self) -> str:
        if self._native.is_remote:
            return f"Farm({self._url!r})"
        return "Farm()"


def native(farm: Farm | str | None) -> _native.Farm:
    """The farm that an argument means: None is this process, or what GONIO_FARM names."""
    if isinstance(farm, Farm):
        return farm._native
    return Farm(farm)._native
