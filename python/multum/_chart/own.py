"""multum's own filters, as warps and as look-ups."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._texture import Texture
from .._warp import warp
from .method import Case, Method, Run, Unavailable

FAMILY = "multum"

SETTINGS: dict[str, dict[str, Any]] = {
    "nearest": {"filter": "nearest"},
    "bilinear": {"filter": "bilinear"},
    "bicubic": {"filter": "bicubic"},
    "trilinear": {"filter": "trilinear"},
    **{f"anisotropic {n}": {"filter": "anisotropic", "max_anisotropy": n} for n in (2, 4, 8, 16, 64)},
    "ewa": {"filter": "ewa"},
    "sat": {"filter": "sat"},
    "area": {"filter": "area"},
    "exact": {"filter": "exact"},
    "stochastic": {"filter": "stochastic"},
    "auto": {"filter": "auto"},
    **{f"auto 1/{n}": {"filter": "auto", "tolerance": 1.0 / n} for n in (16, 64, 256, 1024)},
}

_TRIAL = 128


def methods(patience: float) -> list[Method]:
    """All settings; those that would take longer than ``patience`` seconds a call stand aside."""
    found = []
    for name, options in SETTINGS.items():
        found.append(Method(name, FAMILY, "warp", lambda case, o=options: _warp(case, o, patience)))  # type: ignore[misc]
        found.append(Method(name, FAMILY, "sample", lambda case, o=options: _sample(case, o, patience)))  # type: ignore[misc]
    return found


def _warp(case: Case, options: dict[str, Any], patience: float) -> Run:
    _try(case, options, patience)
    view = case.view
    out = np.empty((view.size, view.size, case.image.shape[2]), np.uint8)
    mapping: NDArray[Any] | None = view.matrix
    if mapping is None:
        mapping = np.stack(view.maps(), axis=-1)

    def work() -> NDArray[Any]:
        warp(case.image, mapping, out.shape[:2], wrap="repeat", out=out, threads=1, **options)
        return out

    return Run(work)


def _sample(case: Case, options: dict[str, Any], patience: float) -> Run:
    _try(case, options, patience)
    texture = Texture(case.image, wrap="repeat")
    uv, jacobian = case.view.uv, case.view.jacobian
    out = np.empty((*uv.shape[:2], case.image.shape[2]), np.float32)

    def work() -> NDArray[Any]:
        texture.sample(uv, jacobian, out=out, threads=1, **options)
        return out

    return Run(work, scale=255.0)


def _try(case: Case, options: dict[str, Any], patience: float) -> None:
    """Some pixels at random tell what all of them would take."""
    pixels = np.random.default_rng(0).integers(0, case.view.size, (2, _TRIAL))
    texture = Texture(case.image, wrap="repeat")
    uv, jacobian = case.view.uv[tuple(pixels)], case.view.jacobian[tuple(pixels)]
    texture.sample(uv[:1], jacobian[:1], threads=1, **options)
    start = time.perf_counter()
    texture.sample(uv, jacobian, threads=1, **options)
    seconds = (time.perf_counter() - start) * case.view.size**2 / _TRIAL
    if seconds > patience:
        raise Unavailable(f"would take about {seconds:.0f} s")
