"""Every method in every case."""

import os
from collections.abc import Callable, Collection, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..demo.figure import Codes, colour
from . import own, peers
from .measure import Contest, contest
from .method import Case, Method
from .report import Chart, machine
from .scenes import SCENES, View
from .textures import TEXTURES
from .truth import BLOCK, blocks, corners


def run(
    image: ArrayLike | None,
    out: str | os.PathLike[str] | None,
    scenes: Sequence[str] | None,
    textures: Sequence[str] | None,
    methods: Sequence[str] | None,
    with_peers: bool,
    *,
    quick: bool,
    view: int | None,
    side: int | None,
    rounds: int | None,
    patience: float,
    tell: Callable[[str], None],
) -> Chart:
    """As `multum.chart`."""
    size = _count("view", view, 192 if quick else 384, BLOCK, 4096)
    texels = _count("side", side, 512 if quick else 1024, 8, 16384)
    turns = _count("rounds", rounds, 4 if quick else 7, 1, 1000)
    chosen = [SCENES[name] for name in _names("scenes", scenes, SCENES)]
    names = _names("textures", textures, TEXTURES)
    if (out is not None or (image is None and "text" in names)) and find_spec("matplotlib") is None:
        raise ValueError("out: drawing needs matplotlib (pip install 'multum[demo]')")
    pictures = {name: TEXTURES[name](texels) for name in names} if image is None else {"image": _codes(image)}
    contestants = _contestants(methods, with_peers, patience, tell)
    made = Chart(
        {
            **machine(),
            "peers": ", ".join(dict.fromkeys(m.family for m in contestants if m.family != own.FAMILY)),
            "view": f"{size} x {size}",
            "textures": ", ".join(f"{k} {v.shape[1]} x {v.shape[0]}" for k, v in pictures.items()),
            "rounds": str(turns),
        }
    )
    shown: list[tuple[Case, Contest]] = []
    for scene in chosen:
        name_of = scene.name
        first = next(iter(pictures.values()))
        seen = View(scene, size, first.shape[1], first.shape[0])
        places = corners(size, 3 if quick else 5)
        tell(f"{name_of}: the truth")
        # All textures at once: the cells of the truth are cut once.
        truth = blocks(seen, np.concatenate(list(pictures.values()), axis=2), places)
        for n, (texture, picture) in enumerate(pictures.items()):
            case = Case(seen, texture, picture)
            right = truth[..., 3 * n : 3 * n + 3]
            result = contest(case, contestants, places, right, turns, tell)
            made.points += result.points
            made.absences += result.absences
            shown.append((case, result))
        for times in (2, 4, 8):
            seen.forget(times)
    if out is not None:
        folder = Path(out)
        folder.mkdir(parents=True, exist_ok=True)
        made.write(folder)
        from .page import write

        tell("drawing")
        write(made, shown, folder)
    return made


def steps(
    image: ArrayLike | None,
    scenes: Sequence[str] | None,
    textures: Sequence[str] | None,
    methods: Sequence[str] | None,
    with_peers: bool,
) -> int:
    """How often `chart` calls ``tell`` with these arguments, for a progress bar."""
    views = len(SCENES if scenes is None else scenes)
    pictures = 1 if image is not None else len(TEXTURES if textures is None else textures)
    absent: list[str] = []
    contestants = len(_contestants(methods, with_peers, 0.0, absent.append))
    return len(absent) + views * (1 + pictures * contestants) + 1


def _contestants(
    wanted: Sequence[str] | None, with_peers: bool, patience: float, tell: Callable[[str], None]
) -> list[Method]:
    found = own.methods(patience) + (peers.methods(tell) if with_peers else [])
    if wanted is not None:
        found = [m for m in found if m.name.startswith(tuple(wanted))]
        if not found:
            names = sorted({m.name for m in own.methods(patience)})
            raise ValueError(f"methods: got {list(wanted)}, expected beginnings of {', '.join(names)}")
    return found


def _names(argument: str, wanted: Sequence[str] | None, known: Collection[str]) -> list[str]:
    names = list(known) if wanted is None else list(wanted)
    for name in names:
        if name not in known:
            raise ValueError(f"{argument}: got {name!r}, expected names of {', '.join(known)}")
    return names


def _codes(image: ArrayLike) -> Codes:
    pixels = np.asarray(image)
    if pixels.dtype != np.uint8:
        raise TypeError(f"image: got {pixels.dtype}, expected uint8")
    if pixels.ndim not in (2, 3) or (pixels.ndim == 3 and pixels.shape[2] not in (1, 3)) or pixels.size == 0:
        raise ValueError(f"image: got shape {pixels.shape}, expected (H, W), (H, W, 1) or (H, W, 3)")
    return colour(pixels)


def _count(argument: str, value: int | None, default: int, least: int, most: int) -> int:
    number = default if value is None else int(value)
    if not least <= number <= most:
        raise ValueError(f"{argument}: got {value}, expected {least} to {most}")
    return number
