"""Memory of large panoramas beside py360convert, and OpenCV with maps made by NumPy: one process each.

    python benches/peers/panorama_memory.py [width]

An equirectangular picture of ``width`` by half of that (default 8192), 8-bit RGB, to a cube and to the same form turned. Prints
megabytes of source and result, and how much the process grew beyond both at most (``resource.getrusage``).
"""

import subprocess
import sys

CODE = """
import resource, sys
import numpy as np
width, who, target = int(sys.argv[1]), sys.argv[2], sys.argv[3]
sky = np.zeros((width // 2, width, 3), np.uint8)
sky += (np.arange(width // 2) % 256).astype(np.uint8)[:, None, None]
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
if who == "multum":
    import multum as mt
    turn = mt.panorama.rotation(20, 35, 10)
    mt.panorama.convert(sky[:64, :128].copy(), size=8)
    before = peak()
    if target == "cube":
        made = mt.panorama.convert(sky, size=width // 4)
    else:
        made = mt.panorama.convert(sky, target="equirect", size=(width, width // 2), rotation=turn)
elif who == "py360convert":
    import py360convert
    before = peak()
    made = np.empty((6, width // 4, width // 4, 3), np.uint8)
    before = peak()
    made[:] = py360convert.e2c(sky, width // 4, cube_format="list")
else:
    import cv2
    before = peak()
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(width // 2) + 0.5) * 2 / width)
    phi, theta = (2 * u - 1) * np.pi, v * np.pi
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    d = d @ np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))[0].T
    x = (np.arctan2(d[..., 0], d[..., 2]) / (2 * np.pi) + 0.5) * width - 0.5
    y = np.arccos(np.clip(d[..., 1], -1, 1)) / np.pi * width / 2 - 0.5
    made = cv2.remap(sky, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
print(sky.nbytes, made.nbytes, peak() - before - made.nbytes)
"""


def main():
    width = sys.argv[1] if len(sys.argv) > 1 else "8192"
    print("| | to | source | result | beyond both |\n|---|---|---|---|---|")
    for who, target in (
        ("multum", "cube"),
        ("py360convert", "cube"),
        ("multum", "equirect, turned"),
        ("OpenCV, NumPy", "equirect, turned"),
    ):
        arguments = [sys.executable, "-c", CODE, width, who, target.split(",")[0]]
        run = subprocess.run(arguments, capture_output=True, text=True, check=True)
        source, result, beyond = (f"{int(n) / 1e6:.0f} MB" for n in run.stdout.split())
        print(f"| {who} | {target} | {source} | {result} | {beyond} |", flush=True)


if __name__ == "__main__":
    main()
