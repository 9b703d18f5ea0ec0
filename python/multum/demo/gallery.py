"""Pictures without a rival: wrap modes, magnification, the pyramid, linear light."""

import numpy as np

from .._pyramid import build_pyramid
from .._texture import Texture
from .._warp import resize, warp
from .figure import Figure, Panel, colour, enlarged
from .pictures import photograph

_MODES = ("border", "clamp", "repeat", "mirror", "mirror_once", "mirror_101")
_FILTERS = (
    ("nearest", "the texel itself"),
    ("bilinear", "4 texels"),
    ("mitchell", "16 texels, soft"),
    ("bicubic", "16 texels, sharp (Catmull-Rom)"),
)


def wrap_modes(scale: float) -> Figure:
    """What lies outside a picture."""
    image = photograph("chelsea", 0.22 * scale)
    height, width = image.shape[:2]
    shape = (round(2.6 * height), round(2.6 * width))
    left, top = (shape[1] - width) // 2, (shape[0] - height) // 2
    shift = np.array([[1.0, 0.0, -left], [0.0, 1.0, -top]])
    panels = []
    for mode in _MODES:
        made = warp(image, shift, shape, wrap=mode, border=[70, 80, 96])
        frame = colour(made).copy()
        for y in (top - 1, top + height):
            frame[y, left - 1 : left + width + 1] = (255, 220, 0)
        for x in (left - 1, left + width):
            frame[top - 1 : top + height + 1, x] = (255, 220, 0)
        panels.append(Panel(frame, f'wrap="{mode}"'))
    return Figure(
        "wrap",
        "Outside the picture",
        "The picture stands in the yellow frame; the rest is what each wrap mode puts around it. Axes can differ: "
        'wrap=("repeat", "clamp").',
        [panels[:3], panels[3:]],
    )


def magnification(scale: float) -> Figure:
    """Few texels, many pixels."""
    image = photograph("chelsea", 0.5)[40:64, 60:92]
    times = max(2, round(8.5 * scale))
    shape = (image.shape[0] * times, image.shape[1] * times)
    panels = [Panel(colour(resize(image, shape, filter=name)), name, note) for name, note in _FILTERS]
    return Figure(
        "magnification",
        "Enlarging",
        f"The eye of the cat, {image.shape[1]} x {image.shape[0]} texels, {times} times enlarged.",
        [panels[:2], panels[2:]],
    )


def pyramid(scale: float) -> Figure:
    """All levels of a picture of odd size."""
    image = photograph("chelsea", scale)
    levels = build_pyramid(image, encoding="srgb")
    height, width = image.shape[:2]
    gap = 6
    side = np.full((height, width // 2 + gap, 3), 255, np.uint8)
    y = 0
    for level in levels[1:]:
        h, w = level.shape[:2]
        if y + h > height:
            break
        side[y : y + h, gap : gap + w] = level
        y += h + gap
    nested = np.concatenate([colour(image), side], axis=1)
    even = []
    for number in (3, 4, 5):
        level = levels[number]
        times = max(1, height // level.shape[0] // 2)
        even.append(
            Panel(colour(enlarged(level, times)), f"level {number}", f"{level.shape[1]} x {level.shape[0]}")
        )
    sizes = ", ".join(f"{level.shape[1]}x{level.shape[0]}" for level in levels)
    texture = Texture(image)
    base = texture.nbytes
    texture.sample([[0.5, 0.5]], lod=[1.0], filter="trilinear")
    measured = [
        f"levels {sizes}",
        f"memory as a texture {base / 1e6:.2f} MB, with all levels {texture.nbytes / 1e6:.2f} MB",
    ]
    return Figure(
        "pyramid",
        "Much in little: the pyramid",
        "Each level has half the size of the one before, rounded down, and each of its texels is the mean of "
        "exactly the area that it stands for, so that nothing drifts at odd sizes. Filters read the level whose "
        "texels are as large as the pixel's footprint.",
        [[Panel(nested, "the picture and its levels", f"{width} x {height}, {len(levels)} levels")], even],
        measured,
    )


def linear_light(scale: float) -> Figure:
    """Averages of codes are not averages of light."""
    size = 8 * round(34 * scale)
    y, x = np.mgrid[:size, :size]
    half = size // 2
    pattern = np.where((x + y) % 2 == 0, 255, 0)
    flat = np.full((size, size), 188)
    stripes = np.where((x % 4) == 0, 255, 0)
    quarter = np.full((size, size), 137)
    image = np.concatenate(
        [
            np.concatenate([pattern[:half, :half], flat[:half, :half]], axis=1),
            np.concatenate([quarter[:half, :half], stripes[:half, :half]], axis=1),
        ]
    ).astype(np.uint8)
    small = [resize(image, (size // 8, size // 8), encoding=e) for e in ("linear", "srgb")]
    middle = [int(s[size // 32, size // 32]) for s in small]
    panels = [
        Panel(colour(image), "before", "checkers beside 188, stripes beside 137"),
        Panel(
            colour(enlarged(small[0], 8)), 'encoding="linear"', f"codes averaged: checkers become {middle[0]}"
        ),
        Panel(
            colour(enlarged(small[1], 8)), 'encoding="srgb"', f"light averaged: checkers become {middle[1]}"
        ),
    ]
    return Figure(
        "linear_light",
        "Averages of light",
        "From afar, black and white checkers look like the plain field beside them, which has half the light "
        "(code 188); one white stripe in four looks like code 137. Reduced 8 times, the average of the sRGB codes "
        "is too dark; "
        'with encoding="srgb" the average is taken of the light itself, and both fields agree.',
        [panels],
        [f"checkers of 0 and 255 reduced: {middle[0]} by codes, {middle[1]} by light"],
    )
