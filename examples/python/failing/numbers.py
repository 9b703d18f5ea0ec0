"""Numbers that lose what they should hold."""

import numpy as np

import multum as mt
from multum.demo.pictures import photograph

from .common import Failure


def cancellation() -> Failure:
    """Cancellation."""
    n, k = 1400, 112
    image = 1000 + np.random.default_rng(0).random((n, n), np.float32)
    table = np.zeros((n + 1, n + 1), np.float32)
    table[1:, 1:] = np.cumsum(np.cumsum(image, axis=0, dtype=np.float32), axis=1, dtype=np.float32)
    at = np.arange(n - k - 3, n - 3)
    lower, upper = np.ix_(at, at), np.ix_(at + 3, at + 3)
    single = (table[upper] - table[np.ix_(at, at + 3)] - table[np.ix_(at + 3, at)] + table[lower]) / 9
    y, x = np.meshgrid(at, at, indexing="ij")
    boxes = np.stack([x, y, x + 3, y + 3], axis=-1) / n
    double = np.asarray(mt.SummedAreaTable(image).mean(boxes)).reshape(k, k)
    wide = image.astype(np.float64)
    truth = sum(wide[np.ix_(at + j, at + i)] for j in range(3) for i in range(3)) / 9
    shown = [np.clip((a - 1000.0) * 255, 0, 255) for a in (single, double, truth)]
    return Failure(
        "Tables of singles",
        "A small box far from the origin is the difference of four large sums. In single precision "
        "its last digits "
        "were lost while the sums grew: noise of 0 to 1 on a ground of 1000, means of 3 by 3 "
        "texels at the far end "
        "of 1400 squared. multum's tables are whole numbers or doubles, and stay so when they are read.",
        "largest error of a mean, table of singles and `SummedAreaTable`",
        float(np.abs(single - truth).max()),
        float(np.abs(double - truth).max()),
        list(zip(("table of singles", "SummedAreaTable", "direct sums"), shown, strict=True)),
    )


def no_numbers() -> Failure:
    """No numbers."""
    entries = [0.0, np.inf, np.nan, 1e30, 1e-30, 0.01]
    rows = np.array(np.meshgrid(*[entries] * 4)).reshape(4, -1).T.reshape(-1, 2, 2)[:1024]
    image = photograph("coffee")[..., :3]
    levels = mt.build_pyramid(image)
    with np.errstate(all="ignore"):
        scaled = (rows * np.array([[600.0], [400.0]])).astype(np.float32)
        lod = np.log2(np.sqrt((scaled**2).sum(axis=1)).max(axis=-1))
        level = np.clip(lod, 0, len(levels) - 1)
    naive = np.zeros((len(rows), 3))
    for i, at in enumerate(level):
        naive[i] = np.nan if np.isnan(at) else levels[int(at)].mean(axis=(0, 1))
    got = 255 * mt.Texture(image).sample(np.full((len(rows), 2), 0.5), rows, filter="auto")
    shown = [np.nan_to_num(a, nan=0).reshape(32, 32, 3).repeat(4, 0).repeat(4, 1) for a in (naive, got)]
    return Failure(
        "Footprints that are no numbers",
        "A clamp lets NaN pass, and the conversion to a whole number makes anything of it. Zeros, "
        "infinities, NaN "
        "and 1e30 in all four places of the Jacobian: multum reads the point for zero and the coarsest level for "
        "what is not finite.",
        "share of results that are no numbers, clamped logarithm and multum",
        float(np.isnan(naive).any(axis=1).mean()),
        float((~np.isfinite(got)).any(axis=1).mean()),
        list(zip(("log2, then clamp (black: NaN)", "multum"), shown, strict=True)),
    )


def tiling() -> Failure:
    """Tiling."""
    n, k = 16384, 96
    strip = np.random.default_rng(1).integers(0, 256, (4, n), np.uint8)
    texture = mt.Texture(strip, wrap="repeat")
    # 96 by 96 places, a tenth of a texel apart, in the thousandth tile.
    u = 1000.25 + np.arange(k * k).reshape(k, k) / (10 * n)
    uv = np.stack([u, np.full((k, k), 0.5)], axis=-1)
    truth = 255 * mt.reference.sample(strip, uv, pixel_filter="point", wrap="repeat")
    single, double = (
        255 * texture.sample(places, filter="bilinear") for places in (uv.astype(np.float32), uv)
    )
    return Failure(
        "A texture of 16384 texels in the thousandth tile",
        "Singles near 1000 are a texel apart: the picture goes in steps. Coordinates in doubles, "
        "or reduced to one "
        "period before they are rounded, keep it smooth.",
        "rms error of 255, `float32` and `float64` coordinates",
        mt.reference.rms(single, truth),
        mt.reference.rms(double, truth),
        [("float32 coordinates", single), ("float64 coordinates", double), ("truth", truth)],
    )


def chains() -> Failure:
    """Chains."""
    image = np.random.default_rng(2).integers(0, 2, (512, 512)).astype(np.uint8) + 100
    chain = [image.astype(int)]
    while len(chain[-1]) > 1:
        a = chain[-1]
        chain.append((a[::2, ::2] + a[1::2, ::2] + a[::2, 1::2] + a[1::2, 1::2] + 2) >> 2)
    levels = mt.build_pyramid(image)
    shown = [
        ((level.astype(float).reshape(16, 16) - 99) * 85).clip(0, 255) for level in (chain[5], levels[5])
    ]
    mean = image.mean()
    return Failure(
        "Levels of bytes made from bytes",
        "Each rounding is up to half a code, and rounding halves up pushes always the same way: "
        "five levels on, a "
        "picture of 100 and 101 in equal parts is brighter by half a code. multum carries singles down the "
        "chain and rounds each level once.",
        "codes by which level 5 is too bright, bytes from bytes and `build_pyramid`",
        float(abs(chain[5].mean() - mean)),
        float(abs(levels[5].astype(float).mean() - mean)),
        [
            (name, a.repeat(6, 0).repeat(6, 1))
            for name, a in zip(("bytes from bytes", "build_pyramid"), shown, strict=True)
        ],
    )


def odd_sizes() -> Failure:
    """Odd sizes."""
    n = 127
    x = np.arange(n) + 0.5
    image = (np.add.outer(x, x) / (2 * n)).astype(np.float32)
    dropped = image
    while len(dropped) > 3:
        even = dropped[: len(dropped) // 2 * 2, : len(dropped) // 2 * 2]
        dropped = (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]) / 4
    level = mt.build_pyramid(image)[5]
    shown = [255 * np.kron(a, np.ones((32, 32))) for a in (dropped, level)]
    return Failure(
        "Odd sizes, two by two",
        "Averages of two by two leave the last row and column of an odd size out; level by level "
        "the picture drifts "
        "to one corner. Weights of three texels, exact shares of their width, keep mean and centre of every level.",
        "what the mean of level 5 of a ramp from 0 to 1 is off, two by two and `build_pyramid`",
        float(abs(dropped.mean() - image.mean())),
        float(abs(level.mean() - image.mean())),
        list(zip(("last rows dropped", "build_pyramid"), shown, strict=True)),
    )
