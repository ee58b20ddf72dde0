#!/usr/bin/env python3
"""Gonio and Mitsuba 3 side by side, in turn, on the same capture.

  peer.py render CAPTURE [--samples 64] [--rounds 5]   wall-clock seconds of both whole programs' work, ratios by round
  peer.py fit CAPTURE [--iterations 10]                seconds of one `gonio fit`; seconds per Adam iteration of the peer

Needs: pip install mitsuba numpy OpenEXR, an LLVM library (DRJIT_LIBLLVM_PATH), and `cargo build --release`.
Captures of what `mitsuba_scene.py` knows.
"""
import argparse, json, pathlib, resource, statistics, subprocess, tempfile, time, tomllib
from mitsuba_scene import scene

GONIO = pathlib.Path(__file__).resolve().parents[2] / "target/release/gonio"


def gonio(*arguments):
    """Seconds of one whole run of the program. For its peak memory use `/usr/bin/time -v`: a child of this process
    inherits this process' own peak."""
    begin = time.time()
    subprocess.run([GONIO, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.time() - begin


def render(mi, np, folder, capture, options):
    ours, theirs = [], []
    for round_ in range(options.rounds + 1):
        with tempfile.TemporaryDirectory() as out:
            seconds = gonio("render", folder, "--out", out, "--samples", options.samples)
        begin = time.time()
        for i, photo in enumerate(capture["photo"]):
            np.array(mi.render(scene(mi, np, folder, capture, photo), spp=options.samples, seed=round_ * 100 + i))
        if round_ > 0:  # the first round compiles the peer's kernels and warms both
            ours.append(seconds)
            theirs.append(time.time() - begin)
    ratios = [t / o for o, t in zip(ours, theirs)]
    return {"gonio_seconds": statistics.median(ours), "mitsuba_seconds": statistics.median(theirs),
            "speed_ratio": statistics.median(ratios), "lowest": min(ratios), "highest": max(ratios),
            "mitsuba_peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def fit(mi, dr, np, folder, capture, options):
    import OpenEXR
    with tempfile.TemporaryDirectory() as out:
        whole = gonio("fit", folder, "--out", out)
        result = json.loads((pathlib.Path(out) / "fit.json").read_text())
    photos = [p for p in capture["photo"] if p.get("role", "fit") == "fit"]
    scenes = [scene(mi, np, folder, capture, p) for p in photos]
    seen = [OpenEXR.File(str(folder / p["file"])).channels()["RGB"].pixels.astype(np.float32) for p in photos]
    material = "material_" + next(m["name"] for m in capture["material"] if m["model"] == "plastic")
    light = "light_" + capture["light"][0]["name"] + ".intensity.value"
    keys = [material + ".diffuse_reflectance.value", material + ".alpha", material + ".eta", light]
    handles = [mi.traverse(s) for s in scenes]
    adam = mi.ad.Adam(lr=0.03)
    for key in keys:
        adam[key] = handles[0][key]
    begin = time.time()
    for step in range(options.iterations):
        for handle, s, photo, y in zip(handles, scenes, photos, seen):
            for key in keys:
                handle[key] = adam[key]
            handle.update()
            image = mi.render(s, handle, spp=16, spp_grad=16, seed=step * 97) * float(photo.get("exposure", 1))
            dr.backward(dr.mean(dr.square(image - mi.TensorXf(y)), axis=None))
        adam.step()
    per_iteration = (time.time() - begin) / options.iterations
    return {"gonio_fit_seconds": result["seconds"], "gonio_whole_seconds": whole,
            "mitsuba_seconds_per_iteration": per_iteration, "ratio_for_150_iterations": 150 * per_iteration / result["seconds"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=["render", "fit"])
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--iterations", type=int, default=10)
    options = parser.parse_args()
    import drjit as dr, mitsuba as mi, numpy as np
    mi.set_variant("llvm_ad_rgb")
    capture = tomllib.loads((options.capture / "capture.toml").read_text())
    run = render(mi, np, options.capture, capture, options) if options.task == "render" else fit(mi, dr, np, options.capture, capture, options)
    print(json.dumps({"capture": capture["name"], **run}, indent=1))


if __name__ == "__main__":
    main()
