#!/usr/bin/env python3
"""Variance times CPU time of Gonio and of Mitsuba 3 (path, independent sampler) on the same captures.

  equal_noise.py CAPTURE... [--samples 64] [--seeds 4] [--timed 512] [--rounds 3] [--photos 2] [--json FILE]

The product is what noise costs: half of the variance at equal time is worth as much as half of the time at equal
variance. A ratio above 1 says that Mitsuba pays more.

- Variance: of a pixel's value across `--seeds` renders of `--samples` samples each, mean over channels, then over pixels
  without the noisiest 1 % of them (fireflies: a few seeds do not know their variance). The mean over all pixels is
  printed too. Both programs are trimmed alike.
- Block: the variance of the mean of 8x8 pixels times 64, over the mean of all pixels' variance: 1 where neighbours' errors
  are independent.
- CPU: user and system seconds, so that other programs on the machine hardly matter; the least of `--rounds`, per sample
  from a render of `--timed` samples less one of 2 samples. So neither start-up nor the compilation of kernels counts.
- Check: the difference of the two mean images in standard errors. Much above 1 says that the scenes are not the same.

Needs: pip install mitsuba numpy OpenEXR, an LLVM library (DRJIT_LIBLLVM_PATH), and `cargo build --release -p gonio`.
"""
import argparse, json, pathlib, resource, subprocess, tempfile, tomllib
from mitsuba_scene import scene

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCK = 8
KEPT = 0.99


class Gonio:
    name = "gonio"

    def __init__(self, np, program, folder, photos):
        import OpenEXR
        self.np, self.exr, self.program, self.folder = np, OpenEXR, program, folder
        self.names = [pathlib.Path(p["file"]).stem for p in photos]

    def render(self, samples, seed):
        """CPU seconds and images."""
        with tempfile.TemporaryDirectory() as out:
            command = [self.program, "render", self.folder, "--out", out, "--samples", samples, "--seed", seed]
            for name in self.names:
                command += ["--photos", name]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            files = [str(pathlib.Path(out) / f"{name}.exr") for name in self.names]
            images = [self.exr.File(f).channels()["RGB"].pixels.astype(self.np.float64) for f in files]
        return cpu(before, after), images


class Mitsuba:
    name = "mitsuba"

    def __init__(self, mi, np, folder, capture, photos):
        self.mi, self.np, self.photos = mi, np, photos
        self.scenes = [scene(mi, np, folder, capture, p) for p in photos]

    def render(self, samples, seed):
        before = resource.getrusage(resource.RUSAGE_SELF)
        images = []
        for i, (s, photo) in enumerate(zip(self.scenes, self.photos)):
            image = self.np.array(self.mi.render(s, spp=samples, seed=seed * 1000 + i), self.np.float64)
            images.append(image * float(photo.get("exposure", 1)))
        return cpu(before, resource.getrusage(resource.RUSAGE_SELF)), images


def cpu(before, after):
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(np, program, options):
    program.render(options.samples, 1)  # compiles kernels, fills caches
    long = min(program.render(options.timed, 1)[0] for _ in range(options.rounds))
    short = min(program.render(2, 1)[0] for _ in range(options.rounds))
    seconds = (long - short) / (options.timed - 2) * options.samples
    renders = [program.render(options.samples, seed)[1] for seed in range(1, options.seeds + 1)]
    variances, blocks, means = [], [], []
    for images in zip(*renders):
        stack = np.stack(images)
        means.append(stack.mean(0))
        variances.append(stack.var(0, ddof=1).mean(-1).ravel())
        k, height, width, channels = stack.shape
        cut = stack[:, :height // BLOCK * BLOCK, :width // BLOCK * BLOCK]
        sums = cut.reshape(k, height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean((2, 4))
        blocks.append((sums.var(0, ddof=1) * BLOCK ** 2).mean(-1).ravel())
    variances, blocks = np.sort(np.concatenate(variances)), np.concatenate(blocks)
    kept = variances[:int(len(variances) * KEPT)]
    return {"variance": kept.mean(), "untrimmed": variances.mean(), "block": blocks.mean() / variances.mean(),
            "cpu": seconds, "product": kept.mean() * seconds, "start": short}, means


def difference(np, ours, theirs, options):
    """Of the two mean images, in standard errors of their means over photos."""
    gaps = [float((a - b).mean()) for a, b in zip(ours[1], theirs[1])]
    pixels = sum(image.shape[0] * image.shape[1] for image in ours[1])
    error = sum(r["untrimmed"] * max(r["block"], 1) for r in (ours[0], theirs[0])) / options.seeds / pixels
    return float(np.mean(gaps)) / error ** 0.5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("captures", type=pathlib.Path, nargs="+")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/gonio")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--timed", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--photos", type=int, default=2, help="how many photos of each capture, from the first on")
    parser.add_argument("--json", type=pathlib.Path, help="also write what was measured here")
    parser.add_argument("--peer", type=pathlib.Path, help="a file of --json: take Mitsuba's figures from there")
    options = parser.parse_args()
    import numpy as np
    known = json.loads(options.peer.read_text()) if options.peer else None
    if not known:
        import mitsuba as mi
        mi.set_variant("llvm_ad_rgb")
    table = {}
    print(f"{'capture':26}{'program':9}{'variance':>11}{'untrimmed':>11}{'block':>7}{'CPU s':>9}{'product':>11}{'ratio':>7}{'check':>7}")
    for folder in options.captures:
        capture = tomllib.loads((folder / "capture.toml").read_text())
        photos = capture["photo"][:options.photos]
        ours = measure(np, Gonio(np, options.program, folder, photos), options)
        if known:
            theirs, check = (known[capture["name"]]["mitsuba"], None), float("nan")
        else:
            theirs = measure(np, Mitsuba(mi, np, folder, capture, photos), options)
            check = difference(np, ours, theirs, options)
        ratio = theirs[0]["product"] / ours[0]["product"]
        table[capture["name"]] = {"gonio": ours[0], "mitsuba": theirs[0], "ratio": ratio}
        for name, r, end in (("gonio", ours[0], ""), ("mitsuba", theirs[0], f"{ratio:7.2f}{check:7.1f}")):
            print(f"{capture['name']:26}{name:9}{r['variance']:11.3e}{r['untrimmed']:11.3e}{r['block']:7.2f}"
                  f"{r['cpu']:9.4f}{r['product']:11.3e}{end}", flush=True)
    ratios = [row["ratio"] for row in table.values()]
    print(f"mean ratio {np.mean(ratios):.2f}, least {min(ratios):.2f}")
    if options.json:
        options.json.write_text(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
