"""A million triangles, and the largest picture: time, memory, and the same bytes for any number of threads.

    python benches/large_scene.py [faces] [side ...]

Draws a textured, lit sheet of waves at each side (default: 2048 and 16384 pixels) with one thread and with all,
each picture in a process of its own. Seconds are the process's own, of all threads together; memory is the most
that it held, less what it held before (Linux).
"""

import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import multum as mt


def waves(faces: int) -> mt.Mesh:
    """A square sheet of about so many triangles, in waves that hide each other."""
    n = round((faces / 2) ** 0.5)
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
    z = 0.05 * np.sin(25 * x + 3 * np.sin(7 * y)) * np.cos(19 * y)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    triangles = np.concatenate([first + np.array(k) for k in ([0, 1, n + 2], [0, n + 2, n + 1])])
    uv = np.stack([x, y], -1).reshape(-1, 2) * 4
    texture = np.random.default_rng(0).integers(0, 256, (512, 512, 3), np.uint8)
    points = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    return mt.Mesh.build(points, triangles, uv=uv.astype(np.float32), texture=texture)


def held(name: str) -> float:
    """Megabytes that the process holds, ``VmRSS``, or held at most, ``VmHWM``."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024


def draw(faces: int, side: int, threads: int) -> None:
    """One picture; prints triangles, seconds, megabytes and the hash of its bytes."""
    scene = mt.Scene(waves(faces))
    camera = mt.Camera((0.8, -1.6, 1.2), up=(0, 0, 1), fov=45)
    # Levels of the texture are made by the first picture.
    mt.render(scene, camera, (64, 64), "trilinear", threads=threads)
    before = held("VmRSS")
    # Forgets the most that was held so far.
    Path("/proc/self/clear_refs").write_text("5")
    start = time.process_time()
    picture = mt.render(scene, camera, (side, side), "trilinear", threads=threads)
    seconds = time.process_time() - start
    grown = held("VmHWM") - before
    covered = float((picture[:: side // 512, :: side // 512, 3] > 0).mean())
    digest = hashlib.blake2b(picture.data, digest_size=8).hexdigest()
    print(len(scene.mesh.faces), f"{seconds:.2f}", f"{grown:.0f}", f"{100 * covered:.0f}", digest)


def main() -> None:
    """The table."""
    if len(sys.argv) == 5 and sys.argv[1] == "--one":
        draw(*(int(word) for word in sys.argv[2:]))
        return
    faces = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    sides = [int(word) for word in sys.argv[2:]] or [2048, 16384]
    print("| triangles | picture | covered | threads | seconds | memory, MB | of it the picture | bytes |")
    print("|---|---|---|---|---|---|---|---|")
    for side in sides:
        digests = set()
        for threads in (1, os.cpu_count() or 1):
            command = [sys.executable, __file__, "--one", str(faces), str(side), str(threads)]
            words = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
            count, seconds, grown, covered, digest = words
            digests.add(digest)
            own = side * side * 4 >> 20
            print(
                f"| {count} | {side} x {side} | {covered} % | {threads} | {seconds} | {grown} | {own} | {digest} |",
                flush=True,
            )
        if len(digests) != 1:
            raise SystemExit(f"{side}: the bytes depend on the number of threads")


if __name__ == "__main__":
    main()
