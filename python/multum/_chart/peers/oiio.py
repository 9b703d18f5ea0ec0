"""OpenImageIO's texture system.

Python calls it once for each look-up, which costs more than the look-up. The time of the same calls on a texture of
one texel, read at the closest point, is taken off; what remains is the filter's own work, and that of making the
result a tuple is not in it.
"""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from ...demo.figure import Codes
from ..method import Case, Method, Run, Unavailable

FAMILY = f"OpenImageIO {oiio.__version__}"

_folder = tempfile.TemporaryDirectory(prefix="multum-chart-")
_paths: dict[int, tuple[Codes, str]] = {}
oiio.attribute("threads", 1)


def _file(image: Codes) -> str:
    """The image as a tiled file with levels; one file for each image object."""
    if id(image) not in _paths:
        path = str(Path(_folder.name) / f"{len(_paths)}.tx")
        if not oiio.ImageBufAlgo.make_texture(
            oiio.MakeTxTexture, oiio.ImageBuf(np.ascontiguousarray(image)), path, oiio.ImageSpec()
        ):
            raise Unavailable(oiio.geterror())
        _paths[id(image)] = image, path
    return _paths[id(image)][1]


_MOST_TEXELS = 2e7
_ONE_TEXEL = np.zeros((1, 1, 3), np.uint8)


def _options(mip: Any, interpolation: Any, anisotropy: int) -> Any:
    options = oiio.TextureOpt()
    options.mipmode, options.interpmode, options.anisotropic = mip, interpolation, anisotropy
    options.swrap = options.twrap = oiio.Wrap.Periodic
    return options


def _look_ups(case: Case, mip: Any, anisotropy: int) -> Run:
    system = oiio.TextureSystem(False)
    system.attribute("max_memory_MB", 512.0)
    view, channels = case.view, case.image.shape[2]
    places = view.uv.reshape(-1, 2).astype(float).tolist()
    # In the order (ds/dx, dt/dx, ds/dy, dt/dy).
    slopes = np.swapaxes(view.jacobian, -1, -2).reshape(-1, 4).astype(float).tolist()
    arguments = [(*place, *slope, channels) for place, slope in zip(places, slopes, strict=True)]
    texture = system.texture

    def calls(path: str, options: Any) -> Callable[[], list[tuple[float, ...]]]:
        return lambda: [texture(path, options, *rest) for rest in arguments]

    read = calls(_file(case.image), _options(mip, oiio.InterpMode.Bilinear, anisotropy))
    bare = calls(_file(_ONE_TEXEL), _options(oiio.MipMode.NoMIP, oiio.InterpMode.Closest, 1))
    bare()
    overhead = min(_seconds(bare) for _ in range(3))

    def work() -> NDArray[Any]:
        return np.array(read(), np.float32).reshape(view.size, view.size, channels)

    return Run(work, 255.0, overhead)


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _warp(case: Case) -> Run:
    """``ImageBufAlgo.warp`` with its own filter; by matrices only."""
    if case.view.matrix is None:
        raise Unavailable("takes matrices only")
    if case.texels > _MOST_TEXELS:
        raise Unavailable(f"would take minutes: {case.texels:.1g} texels")
    size = case.view.size
    # Forward matrices on row vectors, places counted from pixel corners.
    to_centre = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1.0]])
    inside = np.linalg.inv(to_centre @ case.view.matrix @ np.linalg.inv(to_centre))
    matrix = tuple(inside.T.ravel().tolist())
    source = oiio.ImageBuf(np.ascontiguousarray(case.image))
    region = oiio.ROI(0, size, 0, size, 0, 1, 0, case.image.shape[2])

    def work() -> NDArray[Any]:
        made = oiio.ImageBufAlgo.warp(source, matrix, wrap="periodic", roi=region, nthreads=1)
        return np.asarray(made.get_pixels(oiio.UINT8))

    return Run(work)


METHODS = [
    Method("bilinear", FAMILY, "sample", lambda case: _look_ups(case, oiio.MipMode.NoMIP, 1)),
    Method("trilinear", FAMILY, "sample", lambda case: _look_ups(case, oiio.MipMode.Trilinear, 1)),
    Method("anisotropic 4", FAMILY, "sample", lambda case: _look_ups(case, oiio.MipMode.Aniso, 4)),
    Method("anisotropic 16", FAMILY, "sample", lambda case: _look_ups(case, oiio.MipMode.Aniso, 16)),
    Method("warp", FAMILY, "warp", _warp),
]
