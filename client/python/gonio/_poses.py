"""Pose estimation on real and synthetic images."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from typing import Any

from . import _native
from ._results import Evaluation, Prediction
from ._words import Path, call, words


def evaluate(
    dataset: Path,
    results: Path,
    *,
    split: str | None = None,
    targets: Path | None = None,
    out: Path | None = None,
    overlay: bool = False,
) -> Evaluation:
    """Holds estimated poses, a CSV file of BOP's format, against a BOP dataset, as `gonio evaluate` does.

    split: which, where the dataset has several. targets: a JSON file of BOP19 or BOP24. out: a folder for scores and tables;
    overlay: with outlines over every image.
    """
    given = words(split=split, targets=targets, out=out, overlay=overlay)
    return Evaluation(json.loads(_native.evaluate([*given, "--", _text(dataset), _text(results)])))


def predict(
    real: Path,
    synthetic: Path,
    *,
    out: Path | None = None,
    real_results: Path | None = None,
    synthetic_results: Path | None = None,
    contrast: Mapping[str, Path | tuple[Path, Path]] | None = None,
    setting: Mapping[str, tuple[Path, Path]] | None = None,
    margin: float | None = None,
    seed: int = 0,
    distance: tuple[float, float] | None = None,
    estimator: str | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    resume: bool = False,
    progress: Callable[[str], object] | None = None,
) -> Prediction:
    """Tells whether synthetic images of a BOP dataset predict an estimator's recall on real ones, as `gonio predict` does.

    Poses are estimated where no results are named. out: a folder for estimates, prediction.json and the report. contrast: other
    synthetic datasets by name, each with its results if they are there. setting: results on real and synthetic images by another
    setting of the estimator. margin: difference of average recalls that does not matter, 0.05 where it is None. distance: least
    and largest, in metres, for the estimator that is built in. estimator: a program to run instead; timeout: its seconds.
    """
    given = words(
        real_results=real_results,
        synthetic_results=synthetic_results,
        margin=margin,
        seed=seed,
        distance=distance,
        estimator=estimator,
        jobs=jobs,
        timeout=timeout,
        resume=resume,
    )
    for name, sets in (contrast or {}).items():
        paths = sets if isinstance(sets, tuple) else (sets,)
        given.append(f"--contrast={name}={','.join(_text(path) for path in paths)}")
    for name, both in (setting or {}).items():
        given.append(f"--setting={name}={','.join(_text(path) for path in both)}")
    said = call("gonio.predict", real=_text(real), synthetic=_text(synthetic), margin=margin, seed=seed)

    def ask(folder: Path) -> tuple[str, str]:
        return _native.predict([*given, f"--out={_text(folder)}", "--", _text(real), _text(synthetic)], progress, said)

    if out is not None:
        found, page = ask(out)
    else:
        with tempfile.TemporaryDirectory(prefix="gonio-predict-") as folder:
            found, page = ask(folder)
    result: dict[str, Any] = json.loads(found)
    return Prediction(result, page)


def _text(path: Path) -> str:
    return os.fspath(path)
