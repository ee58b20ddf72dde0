"""What fits, diagnoses and comparisons find."""

from __future__ import annotations

import html
import json
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._words import Path

if TYPE_CHECKING:
    from ._capture import Capture


def _in_notebook(page: str) -> str:
    """A page in a frame of its own: its style is not that of the notebook."""
    return (
        '<iframe style="width: 100%; height: 40rem; border: 0" sandbox '
        f'srcdoc="{html.escape(page, quote=True)}"></iframe>'
    )


class Fit:
    """The outcome of a fit. A notebook shows it as its report."""

    def __init__(self, native: _native.Fit, capture: Capture) -> None:
        self._native = native
        self.capture = capture
        """The capture at the estimates."""
        self.result: dict[str, Any] = json.loads(native.json())
        """What fit.json holds."""

    @property
    def values(self) -> dict[str, float]:
        """The estimates by dotted name, in the unit of each number."""
        return {one["name"]: one["value"] for one in self.result["parameters"]}

    @property
    def errors(self) -> dict[str, float | None]:
        """Their standard errors, in the same units; None where the photographs say nothing about a number."""
        return {one["name"]: one["standard_error"] for one in self.result["parameters"]}

    @property
    def covariance(self) -> NDArray[np.float64]:
        """P x P, in the order of `values`: standard errors times correlations, in the numbers' units.

        NaN where a standard error is unknown, and throughout where the solver took no derivatives.
        """
        errors = np.array([np.nan if error is None else error for error in self.errors.values()])
        correlations = self.result["correlations"]
        if not correlations:
            return np.full((len(errors), len(errors)), np.nan)
        # What is unknown is null in JSON, and NaN here.
        return np.array(correlations, dtype=np.float64) * np.outer(errors, errors)

    @property
    def converged(self) -> bool:
        """Whether the step that was left at the end was below the tolerance."""
        return bool(self.result["converged"])

    @property
    def reduced_chi_square(self) -> float:
        """Of the photos that were fitted to; 1 for a right model."""
        return float(self.result["fit"]["reduced_chi_square"])

    @property
    def warnings(self) -> list[str]:
        """What the reader must know, in plain words."""
        return list(self.result["warnings"])

    def report(self) -> str:
        """The report: an HTML page that needs nothing besides itself."""
        return self._native.page()

    def save(self, folder: Path) -> None:
        """Writes capture.toml, fit.json and report.html to `folder`, as the command does."""
        self._native.save(folder)

    def _repr_html_(self) -> str:
        return _in_notebook(self.report())

    def __repr__(self) -> str:
        ended = "converged" if self.converged else "not converged"
        lines = [f"<fit of {self.result['capture']!r}: {ended}, reduced chi-square {self.reduced_chi_square:.4f}"]
        for name, value in self.values.items():
            error = self.errors[name]
            lines.append(f"  {name} = {value:.6g} ± {error:.2g}" if error is not None else f"  {name} = {value:.6g}")
        return "\n".join(lines) + ">"


@dataclass(frozen=True)
class Finding:
    """A cause that a diagnosis found."""

    effects: list[str]
    """The effect, and those that cannot be told from it with these photographs, best first."""
    values: dict[str, float]
    """The numbers that it added, by dotted name."""
    errors: dict[str, float | None]
    """Their standard errors; None where the photographs say nothing."""
    separate_by: str
    """What to photograph to be sure."""


class Diagnosis:
    """The outcome of a diagnosis. A notebook shows it as its report."""

    def __init__(self, native: _native.Diagnosis, capture: Capture) -> None:
        self._native = native
        self.capture = capture
        """The capture, extended by what was found, at the values that were fitted."""
        self.result: dict[str, Any] = json.loads(native.json())
        """What diagnosis.json holds."""
        if native.unjudged is not None:
            warnings.warn(native.unjudged, RuntimeWarning, stacklevel=3)

    @property
    def verdict(self) -> str:
        """"none", "named" or "unexplained"."""
        return str(self.result["verdict"])

    @property
    def found(self) -> list[Finding]:
        """The causes, in the order in which they were added to the model; empty unless the verdict is "named"."""
        return [
            Finding(
                effects=list(one["effects"]),
                values={number["name"]: number["value"] for number in one["parameters"]},
                errors={number["name"]: number["standard_error"] for number in one["parameters"]},
                separate_by=str(one["separate_by"]),
            )
            for one in self.result["found"]
        ]

    def report(self) -> str:
        """The report: an HTML page that needs nothing besides itself."""
        return self._native.page()

    def save(self, folder: Path) -> None:
        """Writes capture.toml, diagnosis.json and report.html to `folder`, as the command does."""
        self._native.save(folder)

    def _repr_html_(self) -> str:
        return _in_notebook(self.report())

    def __repr__(self) -> str:
        found = "; ".join(" or ".join(one.effects) for one in self.found)
        return f"<diagnosis of {self.result['capture']!r}: {self.verdict}{': ' + found if found else ''}>"


class Evaluation:
    """How well poses were estimated."""

    def __init__(self, result: dict[str, Any]) -> None:
        self.result = result
        """What scores.json holds."""

    @property
    def scores(self) -> dict[str, Any]:
        """Recalls over all targets (BOP19): "average_recall", "vsd", "mssd", "mspd", "add_or_add_s"...; or, with the targets of
        BOP24, average precisions."""
        scores: dict[str, Any] = self.result.get("scores") or self.result["detection"]
        return scores

    @property
    def notes(self) -> list[str]:
        """What was left out, and why."""
        return list(self.result["notes"])

    def __repr__(self) -> str:
        numbers = (f"{name} {value:.4f}" for name, value in self.scores.items() if isinstance(value, float))
        return f"<evaluation: {', '.join(numbers)}>"


class Prediction:
    """Whether synthetic images predict an estimator's recall on real ones. A notebook shows it as its report."""

    def __init__(self, result: dict[str, Any], page: str) -> None:
        self.result = result
        """What prediction.json holds."""
        self._page = page

    @property
    def equivalent(self) -> bool:
        """Whether the average recalls are equivalent within the margin."""
        return bool(self.result["equivalent"])

    @property
    def gap(self) -> tuple[float, float, float]:
        """Average recall on synthetic images less that on real ones, with its 95 % interval: value, low, high."""
        gap = self.result["gap"]
        return float(gap["value"]), float(gap["low"]), float(gap["high"])

    def report(self) -> str:
        """The report: an HTML page that needs nothing besides itself."""
        return self._page

    def _repr_html_(self) -> str:
        return _in_notebook(self._page)

    def __repr__(self) -> str:
        value, low, high = self.gap
        return f"<prediction: synthetic less real {value:.4f} [{low:.4f}, {high:.4f}]>"
