"""Panoramas beside OpenCV and py360convert: one thread, one process, alternating calls.

    python benches/peers/panorama.py IMAGE [repeats]

IMAGE is an equirectangular picture, of 8 bits or HDR. For each form prints nanoseconds of the processor a pixel (the least of the
repeats) of ``cv2.remap`` with ready maps, with maps made by NumPy, of py360convert where it has the form, of multum with
``filter="bilinear"`` and of multum; then rms errors against the f64 mean of the bilinear picture over each pixel
(8 x 8 points, at every ninth pixel), as they are and before the result is rounded to 8 bits, and the ratio to OpenCV's. Errors of HDR pictures
are of their logarithms, log(1 + x), so that the sun does not decide alone. py360convert puts its outermost pixels onto
the edges of the picture: it is judged by a truth that does the same.
"""

import os
import sys
import time

# NumPy's own threads would count as work.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import cv2
import numpy as np
import py360convert

import multum as mt

HALF_PI = np.pi / 2


def angular(q, angle):
    """Directions of a disc: angle(radius) from forward."""
    r = np.hypot(q[..., 0], q[..., 1])
    theta = angle(r)
    with np.errstate(invalid="ignore", divide="ignore"):
        k = np.where(r > 0, np.sin(theta) / r, 0)
    d = np.stack([q[..., 0] * k, -q[..., 1] * k, np.cos(theta)], -1)
    return np.where((r <= 1)[..., None], d, np.nan)


def face(q, k):
    a, b, one = q[..., 0], q[..., 1], np.ones(q.shape[:-1])
    axes = [(one, -b, -a), (-one, -b, a), (a, one, b), (a, -one, -b), (a, -b, one), (-a, -b, -one)]
    return np.stack(axes[k], -1)


def octahedron(q):
    x, y = q[..., 0], -q[..., 1]
    z = 1 - abs(x) - abs(y)
    fold = z < 0
    s, t = np.where(x < 0, -1, 1), np.where(y < 0, -1, 1)
    return np.stack([np.where(fold, (1 - abs(y)) * s, x), np.where(fold, (1 - abs(x)) * t, y), z], -1)


def equirect(q):
    phi, theta = q[..., 0] * np.pi, (q[..., 1] + 1) * HALF_PI
    return np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)


def paraboloids(q):
    right = q[..., 0] > 0
    local = np.stack([np.where(right, 2 * q[..., 0] - 1, 2 * q[..., 0] + 1), q[..., 1]], -1)
    d = angular(local, lambda r: 2 * np.arctan(r))
    return np.where(right[..., None], d * [-1, 1, -1], d)


TILT = mt.panorama.rotation(20, 35, 10)


def forms(w):
    """Form: directions at q in [-1, 1]², size, rotation, keywords."""
    eye, n = np.eye(3), w // 4
    return {
        "cube": (None, (n, n), eye, {}),
        "perspective": (
            lambda q: np.stack([q[..., 0], -q[..., 1], np.ones(q.shape[:-1])], -1),
            (n, n),
            eye,
            {},
        ),
        "fisheye": (lambda q: angular(q, lambda r: r * HALF_PI), (2 * n, 2 * n), eye, {}),
        "probe": (lambda q: angular(q, lambda r: r * np.pi), (2 * n, 2 * n), eye, {}),
        "mirror_ball": (
            lambda q: angular(q, lambda r: 2 * np.arcsin(np.minimum(r, 1))) * [1, 1, -1],
            (2 * n, 2 * n),
            eye,
            {},
        ),
        "stereographic": (
            lambda q: angular(q / 2, lambda r: 2 * np.arctan(2 * r * np.tan(np.radians(67.5)))),
            (2 * n, 2 * n),
            eye,
            {},
        ),
        "dual_paraboloid": (paraboloids, (2 * n, n), eye, {}),
        "octahedral": (octahedron, (2 * n, 2 * n), eye, {}),
        "equirect": (equirect, (2 * n, n), TILT, {}),
    }


def maps_of(directions, image, turn):
    """Columns and rows of the equirectangular picture."""
    d = directions @ turn.T
    h, w = image.shape[:2]
    x = (np.arctan2(d[..., 0], d[..., 2]) / (2 * np.pi) + 0.5) * w - 0.5
    y = np.arctan2(np.hypot(d[..., 0], d[..., 2]), d[..., 1]) / np.pi * h - 0.5
    return x, y


def grid(size, dx=0.0, dy=0.0, ends=False):
    """Pixel centres, moved by parts of a pixel, in [-1, 1]²; with ``ends`` the outermost are on the edges."""
    sides = [
        (np.arange(n) + d) / ((n - 1) / 2) - 1 if ends else (np.arange(n) + 0.5 + d) / (n / 2) - 1
        for n, d in zip(size, (dx, dy), strict=True)
    ]
    return np.stack(np.meshgrid(*sides), -1)


def stacked(directions, q):
    return np.concatenate([face(q, k) for k in range(6)]) if directions is None else directions(q)


def bilinear(image, x, y):
    """In f64: periodic along x, the edge goes on along y."""
    h, w = image.shape[:2]
    i, j = np.floor(x), np.floor(y)
    a, b = (x - i)[..., None], (y - j)[..., None]
    i, j = np.nan_to_num(i).astype(np.int64), np.nan_to_num(j).astype(np.int64)
    left, right, up, down = i % w, (i + 1) % w, np.clip(j, 0, h - 1), np.clip(j + 1, 0, h - 1)
    upper = image[up, left] * (1 - a) + image[up, right] * a
    return upper * (1 - b) + (image[down, left] * (1 - a) + image[down, right] * a) * b


def thin(made, size):
    """Every third pixel of every third row, of a picture or of stacked faces."""
    faces = made.reshape(-1, size[1], *made.shape[1:]) if made.shape[0] != size[1] else made[None]
    return faces[:, ::3, ::3].reshape(-1, -(-size[0] // 3), *made.shape[2:])


def truth(image, directions, size, turn, ends=False, k=8):
    parts = (np.arange(k) + 0.5) / k - 0.5
    total = 0.0
    for dy in parts:
        for dx in parts:
            q = grid(size, dx, dy, ends)[::3, ::3]
            total = total + bilinear(image, *maps_of(stacked(directions, q), image, turn))
    return total / k**2


def least(works, repeats):
    times = [[] for _ in works]
    for _ in range(repeats):
        for work, kept in zip(works, times, strict=True):
            start = time.process_time()
            work()
            kept.append(time.process_time() - start)
    return [min(t) for t in times]


def rms(got, want, hdr):
    there = np.isfinite(want).all(-1)
    a, b = got[there].astype(np.float64), want[there]
    if hdr:
        a, b = np.log1p(a), np.log1p(b)
    return float(np.sqrt(np.mean((a - b) ** 2)))


def theirs(name, image, n):
    """py360convert's call, and the part of its result whose directions are ours."""
    if name == "cube":
        call = lambda: py360convert.e2c(image, n, "bilinear", "list")  # noqa: E731
        return call, lambda made: np.asarray(made[0])
    if name == "perspective":
        call = lambda: py360convert.e2p(image, 90, 0, 0, (n, n), mode="bilinear")  # noqa: E731
        return call, np.asarray
    return None, None


def main():
    image = mt.read_image(sys.argv[1])
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 9
    hdr = image.dtype.kind == "f"
    cv2.setNumThreads(1)
    mt.set_num_threads(1)
    wide = image.astype(np.float64)
    print(
        f"{image.shape[1]}x{image.shape[0]} {image.dtype}, one thread; multum {mt.__version__}, OpenCV {cv2.__version__}, "
        f"py360convert {getattr(py360convert, '__version__', '')}\n"
    )
    print(
        "| form | size | remap | maps + remap | py360convert | multum bilinear | multum | error of remap | "
        "of py360convert | of multum | ratio | in floats |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name, (directions, size, turn, keywords) in forms(image.shape[1]).items():

        def make(directions=directions, size=size, turn=turn):
            q = stacked(directions, grid(size))
            return [m.astype(np.float32) for m in maps_of(q, image, turn)]

        def own(kind="auto", picture=image, name=name, size=size, turn=turn, keywords=keywords):
            side = size[0] if name == "cube" else size
            return mt.panorama.convert(picture, "equirect", name, side, turn, filter=kind, **keywords)

        x, y = make()
        remap = lambda image=image, x=x, y=y: cv2.remap(
            image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
        )  # noqa: E731
        call, part = theirs(name, image, size[0])
        works = [
            remap,
            lambda: cv2.remap(image, *make(), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP),
            lambda: own("bilinear"),
            own,
        ]
        works += [call] if call else []
        pixels = x.size
        times = [t / pixels * 1e9 for t in least(works, repeats)]
        want = truth(wide, directions, size, turn)
        full = (y.shape[0], y.shape[1], image.shape[2])
        errors = [rms(thin(made.reshape(full), size), want, hdr) for made in (remap(), own())]
        single = image.astype(np.float32)
        floats = [
            rms(thin(made.reshape(full), size), want, hdr)
            for made in (remap(image=single), own(picture=single))
        ]
        there = ("-", "-")
        if call:
            judge = truth(wide, lambda q: face(q, 4), size, turn, ends=True)
            there = (f"{times[4]:.0f}", f"{rms(thin(part(call()), size), judge, hdr):.3g}")
        print(
            f"| {name} | {size[0]}x{size[1]}{' x 6' * (name == 'cube')} | {times[0]:.1f} | {times[1]:.0f} | {there[0]} | "
            f"{times[2]:.1f} | {times[3]:.1f} | {errors[0]:.3g} | {there[1]} | {errors[1]:.3g} | "
            f"{errors[1] / errors[0]:.2f} | {floats[1] / floats[0]:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
