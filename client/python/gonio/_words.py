"""Options of Python as those of the command line, by which they are checked."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

Path = str | os.PathLike[str]


def words(**options: object) -> list[str]:
    """`samples=16, max_iterations=None` as `["--samples=16"]`: None and False say nothing."""
    out: list[str] = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            out.append(flag)
        elif isinstance(value, Mapping):
            out += [f"{flag}={key}={number(entry)}" for key, entry in value.items()]
        elif isinstance(value, float):
            out.append(f"{flag}={number(value)}")
        elif isinstance(value, Iterable) and not isinstance(value, (str, os.PathLike)):
            out.append(f"{flag}={','.join(str(entry) for entry in value)}")
        else:
            out.append(f"{flag}={value}")
    return out


def call(what: str, **options: object) -> str:
    """How a report says that it was made: the call with what was given."""
    given = [f"{name}={value!r}" for name, value in options.items() if value is not None]
    return f"{what}({', '.join(given)})"


def number(value: object) -> str:
    """A number with all of its digits."""
    return repr(float(value)) if isinstance(value, (int, float)) else repr(float(str(value)))
