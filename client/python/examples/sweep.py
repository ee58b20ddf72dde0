"""Renders a part at several roughnesses and tells how its brightest pixel follows.

    python sweep.py [CAPTURE]
"""

import sys
import tempfile
from pathlib import Path

import gonio

SWEEP = """
format = 1
capture = {capture!r}
samples = 16
resolution = 0.5
photos = ["00"]
outputs = ["exr"]

[[design]]
kind = "grid"
axes = [{{ name = "material.shell.roughness", values = [0.2, 0.4, 0.6] }}]
"""


def main(path: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sweep.toml"
        file.write_text(SWEEP.format(capture=str(Path(path).resolve())), encoding="utf-8")
        brightest = {}
        for frame in gonio.sweep(file, out=Path(folder) / "out"):
            assert frame.image is not None
            brightest[frame.values["material.shell.roughness"]] = float(frame.image.max())
        for roughness, value in sorted(brightest.items()):
            print(f"roughness {roughness}: brightest photo value {value:.3f}")
        # A smooth surface gathers a lamp's light in a small highlight, a rough one spreads it.
        assert brightest[0.2] > brightest[0.4] > brightest[0.6]
        # What is there is not rendered again.
        again = [frame.digest for frame in gonio.sweep(file, out=Path(folder) / "out")]
        assert len(again) == 3


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "tests/captures/none-201")
