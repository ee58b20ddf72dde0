"""Fits a capture, compares a photograph with its render, and keeps the result.

    python fit.py [CAPTURE [FOLDER]]
"""

import sys
import tempfile

import numpy as np

import gonio


def main(path: str, folder: str) -> None:
    capture = gonio.load(path)
    print(capture)
    fit = capture.fit(samples=16, progress=print)
    print(fit)

    # Standard errors are the roots of the covariance's diagonal.
    for (name, error), variance in zip(fit.errors.items(), np.diag(fit.covariance), strict=True):
        assert error is None or np.isclose(error, np.sqrt(variance)), name

    # A photograph that nothing was fitted to, against its render at the estimates.
    name = capture.held_out[0]
    residual = (capture.photos[name] - fit.capture.render(name, samples=64))[capture.masks[name]]
    print(f"photo {name}: root mean squared residual {np.sqrt(np.mean(residual**2)):.5f}")

    # A report that a notebook shows by itself, and files that other commands go on with.
    assert fit.report().startswith("<!DOCTYPE html>")
    fit.save(folder)
    assert gonio.load(folder).numbers == fit.capture.numbers


if __name__ == "__main__":
    where = sys.argv[1] if len(sys.argv) > 1 else "tests/captures/none-201"
    with tempfile.TemporaryDirectory() as temporary:
        main(where, sys.argv[2] if len(sys.argv) > 2 else temporary)
