#!/usr/bin/env python3
"""Gonio's ray engine and Intel's Embree, in turn on the same rays, one thread each.

    pip install embreex numpy
    cargo build --release -p gonio-tracer --example rays
    python3 worker/tracer/benches/embree.py [--triangles 100000 1000000] [--rounds 11] [--json FILE]

Embree traces one ray after another by rtcIntersect1 / rtcOccluded1, through embreex. Both engines take turns on each
slice of the rays, so that a noisy machine disturbs both alike; the figure is the median of the ratios of one turn.
Meshes: a bumpy sphere in a room of twelve triangles, and hills. Rays: those of a camera in tiles of 4 x 4 pixels, and
diffuse bounces from where they end, shuffled. Distances must agree to 1e-3, and all but one ray in 10 000 in hitting.
Embree's times include embreex's loop over the rays, which for `closest` costs about as much as a quick ray itself:
called from compiled code rtcIntersect1 is up to twice as fast as shown, rtcOccluded1 a tenth.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

try:
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh
except ImportError:
    sys.exit("embreex is missing: pip install embreex numpy")

ROOT = pathlib.Path(__file__).resolve().parents[3]


def grid(function, columns, rows):
    """Triangles of a surface over the unit square."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    points = np.stack(function(u, v), axis=-1).astype(np.float32)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)


def sphere_in_room(count):
    def bumpy(u, v):
        phi, theta = 2 * np.pi * u, np.pi * v
        x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        r = 1 + 0.1 * np.sin(7 * x) * np.sin(6 * y) * np.sin(8 * z) + 0.02 * np.sin(40 * x + 30 * y) * np.sin(35 * z)
        return r * x, r * y, r * z

    rows = int((count / 4) ** 0.5)
    walls = []
    for axis in range(3):
        for side in (-3.0, 3.0):
            def wall(u, v, axis=axis, side=side):
                flat = [6 * u - 3, 6 * v - 3]
                flat.insert(axis, np.full_like(u, side))
                return flat
            walls.append(grid(wall, 1, 1))
    return np.concatenate([grid(bumpy, 2 * rows, rows), *walls])


def hills(count):
    side = int((count / 2) ** 0.5)
    return grid(lambda u, v: (6 * u - 3, 6 * v - 3, 0.5 * np.sin(5 * u + 1) * np.cos(6 * v) + 0.05 * np.sin(50 * u)
                              * np.sin(40 * v) - 0.5), side, side)


def camera(width):
    tile, inside = np.divmod(np.arange(width * width), 16)
    x = (tile % (width // 4)) * 4 + inside % 4 + 0.5
    y = (tile // (width // 4)) * 4 + inside // 4 + 0.5
    origin = np.array([2.6, 1.9, 1.6])
    forward = -origin / np.linalg.norm(origin)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    offset = 0.5 * (2 * np.stack([x, y], axis=1) / width - 1)
    direction = forward + offset[:, :1] * right + offset[:, 1:] * down
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return np.broadcast_to(origin, direction.shape).astype(np.float32), direction.astype(np.float32)


def bounces(scene, triangles, origin, direction, random):
    hit = scene.run(origin, direction, output=True)
    met = hit["primID"] >= 0
    corners = triangles[hit["primID"][met]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    normal *= -np.sign(np.sum(normal * direction[met], axis=1, keepdims=True))
    start = origin[met] + hit["tfar"][met, None] * direction[met] + 1e-4 * normal
    ball = random.normal(size=start.shape)
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    turned = normal + 0.999 * ball
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    order = random.permutation(len(start))
    return start[order].astype(np.float32), turned[order].astype(np.float32)


class Gonio:
    """The example program `rays`, asked line by line."""

    def __init__(self, folder, triangles):
        triangles.astype("<f4").tofile(folder / "mesh")
        binary = ROOT / "target/release/examples/rays"
        if not binary.exists():
            sys.exit(f"{binary} is missing: cargo build --release -p gonio-tracer --example rays")
        pipe = subprocess.PIPE
        self.process = subprocess.Popen([binary, folder / "mesh"], stdin=pipe, stdout=pipe, text=True)
        self.build_seconds = json.loads(self.process.stdout.readline())["build_seconds"]
        self.folder = folder

    def run(self, query, file):
        """Seconds, and the answers."""
        print(query, self.folder / file, self.folder / "answers", file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline())["seconds"], np.fromfile(self.folder / "answers", "<f4")


def embree(scene, query, origin, direction):
    """Seconds, and the answers in the same form."""
    start = time.perf_counter()
    if query == "occluded":
        answer = scene.run(origin, direction, query="OCCLUDED")
        return time.perf_counter() - start, np.where(answer == 0, 1.0, 0.0)
    answer = scene.run(origin, direction, query="DISTANCE")
    return time.perf_counter() - start, np.where(answer < 1e30, answer, -1.0)


def disagreement(query, ours, theirs):
    if query == "occluded":
        return np.mean(ours != theirs)
    both = (ours >= 0) & (theirs >= 0)
    apart = np.abs(ours - theirs) > 1e-3 * np.maximum(theirs, 0.1)
    return np.mean((ours >= 0) != (theirs >= 0)) + np.mean(both & apart)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, nargs="+", default=[100_000, 1_000_000])
    parser.add_argument("--width", type=int, default=512, help="pixels of the camera's side, a multiple of 4")
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--json", help="also write the figures to this file")
    options = parser.parse_args()
    figures, worst = [], 0.0
    print(f"{'mesh':16} {'triangles':>9} {'rays':8} {'query':9} {'Gonio':>8} {'Embree':>8}   ratio")
    for make in (sphere_in_room, hills):
        for count in options.triangles:
            triangles = make(count)
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                gonio = Gonio(folder, triangles)
                scene = rtcore_scene.EmbreeScene()
                vertices, corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
                start = time.perf_counter()
                TriangleMesh(scene, vertices, corner.reshape(-1, 3).astype(np.int32))
                near = camera(options.width)
                scene.run(near[0][:1], near[1][:1])
                build = time.perf_counter() - start
                cases = {"camera": near, "diffuse": bounces(scene, triangles, *near, np.random.default_rng(1))}
                for name, (origin, direction) in cases.items():
                    slices = np.array_split(np.arange(len(origin) // 16 * 16).reshape(-1, 16), 4)
                    parts = [(origin[s.ravel()], direction[s.ravel()]) for s in slices]
                    for i, (o, d) in enumerate(parts):
                        span = np.tile(np.array([0, np.inf]), (len(o), 1))
                        np.hstack([o, d, span]).astype("<f4").tofile(folder / f"{name}{i}")
                    queries = ["closest", "occluded"] + ["packet"] * (name == "camera")
                    for query in queries:
                        turns = []
                        for turn in range(options.rounds * len(parts)):
                            i = turn % len(parts)
                            ours, mine = gonio.run(query, f"{name}{i}")
                            theirs, yours = embree(scene, query, *parts[i])
                            turns.append((len(mine) / ours / 1e6, len(mine) / theirs / 1e6, theirs / ours))
                            worst = max(worst, disagreement(query, mine, yours))
                        speed = np.median(np.array(turns), axis=0)
                        mesh = make.__name__
                        print(f"{mesh:16} {len(triangles):9} {name:8} {query:9} {speed[0]:8.2f} {speed[1]:8.2f} "
                              f"{speed[2]:7.2f}", flush=True)
                        figures.append({"mesh": mesh, "triangles": len(triangles), "rays": name, "query": query,
                                        "gonio_mrays_per_second": speed[0], "embree_mrays_per_second": speed[1],
                                        "ratio": speed[2], "gonio_build_seconds": gonio.build_seconds,
                                        "embree_build_seconds": build})
                print(f"{make.__name__:16} {len(triangles):9} build, all threads: Gonio {gonio.build_seconds:.2f} s, "
                      f"Embree {build:.2f} s")
                gonio.process.stdin.close()
                gonio.process.wait()
    print(f"largest share of rays on which the two disagree: {worst:.1e}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(figures, indent=1))
    if worst > 1e-4:
        sys.exit("the engines disagree")


if __name__ == "__main__":
    main()
