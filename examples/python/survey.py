"""A floor to the horizon, what `auto` spends on each of its pixels, and the level that each is read on.

Writes survey.png and prints the least, the median and the largest of both.
"""

import numpy as np

import multum as mt
from multum.demo.compare import plane_scene

tiles, matrix, shape, _ = plane_scene(0.6)
floor = mt.warp(tiles, matrix, shape, wrap="repeat", encoding="srgb")
survey = mt.survey(tiles, matrix, shape, wrap="repeat", encoding="srgb")
for name, values in survey._asdict().items():
    print(f"{name}: least {values.min():.1f}, median {np.median(values):.1f}, largest {values.max():.1f}")
mt.write_image("survey.png", np.hstack([floor, survey.picture("cost"), survey.picture("lod")]))
