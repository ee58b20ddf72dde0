"""Renders a photo of a capture before and after a change, and looks at its geometry.

    python render.py [CAPTURE]
"""

import sys

import numpy as np

import gonio


def main(path: str) -> None:
    capture = gonio.load(path)
    photo = next(iter(capture.photos))
    before = capture.render(photo, samples=16)
    print(f"{photo}: {before.dtype} {before.shape}, mean {before.mean():.4f}")

    # A colour is an array of three; light that is half as bright makes photo values half as large.
    brighter = capture.copy()
    lamp = np.asarray(brighter["light.led.intensity"])
    brighter["light.led.intensity"] = 2 * lamp
    after = brighter.render(photo, samples=16)
    assert np.allclose(after, 2 * before, rtol=1e-5)

    # What the camera sees first: which object, how far away, under which normal.
    hits = capture.render(photo, samples=16, buffers=True)
    assert np.array_equal(hits.image, before)
    for index, name in enumerate(capture.objects):
        seen = hits.objects == index
        print(f"{name}: {seen.sum()} pixels, {hits.depth[seen].min():.3f} m to {hits.depth[seen].max():.3f} m")
        assert np.allclose(np.linalg.norm(hits.normals[seen], axis=-1), 1, atol=1e-5)

    # What is out of bounds is refused in the command line's own words.
    try:
        capture["material.shell.roughness"] = 1.7
    except gonio.InputError as error:
        print(error)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "tests/captures/none-201")
