"""Gonio fits light, colour, roughness and index of refraction of real parts from ordinary calibrated photographs.

    import gonio
    capture = gonio.load("tests/captures/none-201")
    capture["material.shell.roughness"] = 0.3
    image = capture.render("03", samples=64)        # float32, H x W x 3
    fit = capture.fit(progress=print)               # fit.values, fit.errors, fit.covariance, fit.capture, fit.report()

Everything is done by the code of the `gonio` command, which this package holds, too: arrays have the bits of its files. What
cannot be done raises GonioError, for bad input its InputError, in the command's own words.
"""

from ._capture import Buffers, Capture, load
from ._farm import Farm
from ._native import GonioError, InputError
from ._poses import evaluate, predict
from ._results import Diagnosis, Evaluation, Finding, Fit, Prediction
from ._sweep import Frame, sweep

__all__ = [
    "Buffers",
    "Capture",
    "Diagnosis",
    "Evaluation",
    "Farm",
    "Finding",
    "Fit",
    "Frame",
    "GonioError",
    "InputError",
    "Prediction",
    "evaluate",
    "load",
    "predict",
    "sweep",
]
