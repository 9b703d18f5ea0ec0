"""Sheets of the places where mapping functions fail, and what the library does there."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .. import mapping
from .._sphere import SphereTexture
from ..demo.figure import Codes, Figure, Panel
from .maps import projector_matrix

Array = NDArray[np.float64]

_GREY = 0.55


def _codes(colour: Array) -> Codes:
    picture: Codes = np.floor(np.clip(colour, 0, 1) * 255 + 0.5).astype(np.uint8)
    return picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, -1)


def _screen(size: int, half: float = 1.0) -> tuple[Array, Array]:
    """Centres of the pixels of a square picture, in [-half, half], y upwards."""
    x = ((np.arange(size) + 0.5) / size * 2 - 1) * half
    across, up = np.meshgrid(x, -x)
    return across, up


def _board(uv: Array, jacobian: Array | None) -> Codes:
    """A checkerboard; grey where there is no answer."""
    there = np.asarray(np.isfinite(uv).all(-1))
    white = np.nan_to_num(mapping.checkerboard(uv, 16, jacobian=jacobian))
    return _codes(np.where(there, 0.15 + 0.8 * white, _GREY))


def _across(normal: Array, dp: Array) -> Array:
    """What a tangent adds to a unit vector."""
    return np.asarray(dp - normal * (normal * dp).sum(-1, keepdims=True))


def _looking(size: int, forward: tuple[float, float, float], half: float) -> tuple[Array, Array, Array]:
    """Directions of a camera's pixels, and what one pixel right and one down add."""
    z = np.array(forward) / np.linalg.norm(forward)
    x = np.cross([0.0, 0.0, 1.0], z) if abs(z[1]) > 0.9 else np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    across, up = _screen(size, half)
    step = 2 * half / size
    d = across[..., None] * x + up[..., None] * y + z
    return d, np.broadcast_to(step * x, d.shape), np.broadcast_to(-step * y, d.shape)


def _poles(size: int) -> list[list[Panel]]:
    d, dx, dy = _looking(size, (0, 1, 0), 0.08)
    m = mapping.Equirect()
    uv, jacobian = m(d, dpdx=dx, dpdy=dy)
    ring = np.hypot(d[..., 0], d[..., 2]) / np.linalg.norm(d, axis=-1)
    noise = np.random.default_rng(1).random((64, 128))
    sky = SphereTexture(noise)
    return [
        [
            Panel(_board(uv, None), "one point a pixel", "ragged at the pole"),
            Panel(_board(uv, jacobian), "filtered", "the ring's average"),
            Panel(
                _codes(np.clip(0.008 / np.maximum(ring, 1e-9), 0, 1)), "stretch of u", "1/sin θ, unbounded"
            ),
            Panel(
                _codes(sky.sample(d, dx, dy, filter="nearest")[..., 0]), "noise, nearest", "64 x 128 texels"
            ),
            Panel(_codes(sky.sample(d, dx, dy)[..., 0]), "noise, SphereTexture", "read across the pole"),
        ]
    ]


def _seam(size: int) -> list[list[Panel]]:
    d, dx, dy = _looking(size, (0, 0.2, -1), 0.3)
    uv, jacobian = mapping.Equirect()(d, dpdx=dx, dpdy=dy)
    slopes = np.stack([np.gradient(uv, axis=1), np.gradient(uv, axis=0)], -1)
    noise = np.repeat(np.random.default_rng(2).random((24, 48)), 2, 1).repeat(2, 0)
    sky = SphereTexture(noise)
    return [
        [
            Panel(_board(uv, slopes), "differences of u", "u jumps by a turn"),
            Panel(_board(uv, jacobian), "analytic Jacobian", "the jump is not in it"),
            Panel(_codes(10 * np.abs(slopes[..., 0, 0])), "∂u/∂x, differences", "x 10"),
            Panel(_codes(10 * np.abs(jacobian[..., 0, 0])), "∂u/∂x, analytic", "x 10"),
            Panel(_codes(sky.sample(d, dx, dy)[..., 0]), "SphereTexture", "goes on across"),
        ]
    ]


def _axis(size: int) -> list[list[Panel]]:
    across, up = _screen(size, 0.15)
    point = np.stack([across, up, np.zeros_like(across)], -1)
    step = 0.3 / size
    dx, dy = np.broadcast_to([step, 0, 0], point.shape), np.broadcast_to([0, -step, 0], point.shape)
    uv, jacobian = mapping.Cylindrical(height=(-1, 1))(point, dpdx=dx, dpdy=dy)
    middle = np.array([[0.0, 0.0, 0.0], [1e-300, 0.0, 0.0]])
    stage = mapping.TwoStage("sphere", "centroid", radius=2)
    away, _ = stage(middle, dpdx=np.ones((2, 3)), dpdy=np.ones((2, 3)))
    uvs, jacobians = stage(point + np.array([0, 0, 0.02]), dpdx=dx, dpdy=dy)
    note = f"on it u = {away[0, 0]}"
    return [
        [
            Panel(_board(uv, None), "cap, points", "cylindrical map"),
            Panel(_board(uv, jacobian), "cap, filtered", "on the axis all u"),
            Panel(_board(uvs, None), "centroid, points", "a plane just past it"),
            Panel(_board(uvs, jacobians), "centroid, filtered", note),
        ]
    ]


def _misses(size: int) -> list[list[Panel]]:
    return [_mirrored(size, 1.5, "in"), _mirrored(size, 0.8, "around")]


def _mirrored(size: int, radius: float, place: str) -> list[Panel]:
    """A ball that mirrors the board on an intermediate surface larger or smaller than itself."""
    across, up = _screen(size)
    inside = across**2 + up**2 < 0.96
    depth = np.sqrt(np.maximum(1 - across**2 - up**2, 0.04))
    n = np.stack([across, up, depth], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    step = 2 / size
    dx, dy = (_across(n, np.broadcast_to(e, n.shape)) for e in ([step, 0, 0], [0, -step, 0]))
    panels = []
    for intermediate in ("plane", "cylinder", "sphere", "cube"):
        m = mapping.TwoStage(
            intermediate, "reflected_ray", eye=(0, 0, 6), radius=radius, height=(-0.7, 0.7), axis="y"
        )
        uv, jacobian = m(n, n, dx, dy, dndx=dx, dndy=dy)
        met = np.isfinite(uv).all(-1) & inside
        board = np.where(inside[..., None], _board(uv, jacobian), 247).astype(np.uint8)
        panels.append(Panel(board, f"{place} a {intermediate}", f"coverage {met.sum() / inside.sum():.0%}"))
    return panels


def _edges(size: int) -> list[list[Panel]]:
    faces = np.random.default_rng(4).random((6, 8, 8))
    sky = SphereTexture(faces, "cube")
    d = _looking(size, (1, 1, 1), 0.7)[0]
    answer = mapping.Cube("faces")(d)
    face, uv = answer[..., 0].astype(np.int64), answer[..., 1:]
    column = np.clip(np.floor(uv * 8), 0, 7).astype(np.int64)
    at = uv * 8 - 0.5
    low = np.clip(np.floor(at), 0, 6).astype(np.int64)
    part = np.clip(at - low, 0, 1)
    corners = [faces[face, low[..., 1] + j, low[..., 0] + i] for j in (0, 1) for i in (0, 1)]
    upper = corners[0] * (1 - part[..., 0]) + corners[1] * part[..., 0]
    lower = corners[2] * (1 - part[..., 0]) + corners[3] * part[..., 0]
    clamped = upper * (1 - part[..., 1]) + lower * part[..., 1]
    level = sky.sample(d, lod=np.full(d.shape[:2], 2.0), filter="trilinear")[..., 0]
    means = np.asarray(faces.reshape(6, 2, 4, 2, 4).mean((2, 4)))
    blocks = means[face, column[..., 1] // 4, column[..., 0] // 4]
    return [
        [
            Panel(_codes(faces[face, column[..., 1], column[..., 0]]), "texels", "8 x 8 a face"),
            Panel(_codes(clamped), "faces by themselves", "lines at edges"),
            Panel(_codes(sky.sample(d, filter="bilinear")[..., 0]), "SphereTexture", "goes on across"),
            Panel(_codes(blocks), "level 2, texels", "2 x 2 a face"),
            Panel(_codes(level), "level 2, trilinear", "goes on across"),
        ]
    ]


def _projectors(size: int) -> list[list[Panel]]:
    across, up = _screen(size, 1.5)
    floor = np.stack([across, up, np.full_like(across, 0.1)], -1)
    rows = projector_matrix((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    step = 3 / size
    dx, dy = np.broadcast_to([step, 0, 0], floor.shape), np.broadcast_to([0, -step, 0], floor.shape)
    q = np.concatenate([floor, np.ones((*floor.shape[:2], 1))], -1) @ rows.T
    naive = q[..., :2] / q[..., 3:]
    naive = np.where((np.abs(naive - 0.5) < 0.5).all(-1, keepdims=True), naive, np.nan)
    m = mapping.Projective(rows)
    uv, jacobian = m(floor, dpdx=dx, dpdy=dy)
    inside = (np.abs(uv - 0.5) < 0.5).all(-1, keepdims=True)
    wall = np.stack([across, np.full_like(across, 1.0), up], -1)
    wall_dy = np.broadcast_to([0, 0, -step], wall.shape)
    panels = [
        Panel(_board(naive, None), "q not looked at", "a second picture behind"),
        Panel(_board(np.where(inside, uv, np.nan), jacobian), "q <= 0: no answer", "NaN, coverage 0"),
    ]
    for sign, title in ((-1.0, "a wall"), (1.0, "a wall's back")):
        normal = np.broadcast_to([0.0, sign, 0.0], wall.shape)
        seen, slope = mapping.Projective(rows, back_faces=False)(wall, normal, dx, wall_dy)
        inside = (np.abs(seen - 0.5) < 0.5).all(-1, keepdims=True)
        note = "back_faces=False" if sign > 0 else "faces the projector"
        panels.append(Panel(_board(np.where(inside, seen, np.nan), slope), title, note))
    return [panels]


def _said(work: Callable[[], object]) -> str:
    """What a refusal says."""
    try:
        work()
    except ValueError as error:
        return str(error)
    return ""


def _shrinking(size: int) -> tuple[list[Panel], list[str]]:
    """Bounds and determinants on their way to zero."""
    across, up = _screen(size)
    point = np.stack([across, up, np.zeros_like(across)], -1)
    step = 2 / size
    dx, dy = np.broadcast_to([step, 0, 0], point.shape), np.broadcast_to([0, -step, 0], point.shape)
    panels = []
    for width in (1.0, 0.1, 0.01):
        m = mapping.Planar("z", ((-width, -1, -1), (width, 1, 1)))
        panels.append(Panel(_board(*m(point, dpdx=dx, dpdy=dy)), f"bounds {2 * width:g} wide"))
    nothing = np.full((size, size, 3), int(255 * _GREY), np.uint8)
    panels.append(Panel(nothing, "bounds 0 wide", "refused"))
    told = [_said(lambda: mapping.Planar("z", ((0, -1, -1), (0, 1, 1))))]
    return panels, told


def _determinants(size: int) -> tuple[list[Panel], list[str]]:
    across, up = _screen(size)
    st = np.stack([across, -up], -1) * 0.5 + 0.5
    step = np.eye(2) / size
    panels = []
    for gap in (1.0, 0.1, 0.01):
        m = mapping.Linear(1, 1 - 2 * gap, 0, 0.5, 0.5, 0)
        uv, jacobian = m(st, dpdx=np.broadcast_to(step[0], st.shape), dpdy=np.broadcast_to(step[1], st.shape))
        largest = float(np.abs(m.inverse()(np.array([1.0, 0.0]))).max())
        panels.append(Panel(_board(uv, jacobian), f"ae - bd = {gap:g}", f"inverse up to {largest:g}"))
    m = mapping.Linear(1, 1, 0, 0.5, 0.5, 0)
    uv, jacobian = m(st, dpdx=np.broadcast_to(step[0], st.shape), dpdy=np.broadcast_to(step[1], st.shape))
    panels.append(Panel(_board(uv, jacobian), "ae = bd", "no inverse"))
    return panels, [_said(m.inverse)]


def _slivers(size: int) -> tuple[list[Panel], list[str]]:
    """A triangle ever thinner, by the plain 2 x 2 inverse in singles and by ``barycentric``."""
    rng = np.random.default_rng(6)
    panels, told = [], []
    across, up = _screen(size)
    for thin in (1.0, 1e-3, 1e-6, 1e-9):
        a, b, c = (np.array(p) for p in ((0.1, 0.1), (0.9, 0.4), (0.5, 0.25 + 0.6 * thin)))
        weights = rng.dirichlet(np.ones(3), size * size)
        points = weights @ np.stack([a, b, c])
        e, f, g = (v.astype(np.float32) for v in (b - a, c - a, points - a))
        det = e[0] * f[1] - e[1] * f[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            beta = (g[:, 0] * f[1] - g[:, 1] * f[0]) / det
            gamma = (e[0] * g[:, 1] - e[1] * g[:, 0]) / det
            plain = np.stack([1 - beta - gamma, beta, gamma], -1)
        got = np.asarray(mapping.barycentric(points, np.stack([a, b, c]))[0])
        off = [
            np.nanmedian(np.abs(w - weights).max(-1)) if np.isfinite(w).any() else np.inf
            for w in (plain, got)
        ]
        told.append(
            f"thinness {thin:g}: median error of the weights {off[0]:.1e} in singles, {off[1]:.1e} here"
        )
        shape = np.stack([a, b, a + (c - a) + np.array([0.0, 0.3 * (1 - thin)])])
        place = np.stack([across, -up], -1) * 0.5 + 0.5
        inner, inside = mapping.barycentric(place, shape)
        seen = inner @ np.stack([a, b, c])
        h = (seen - a).astype(np.float32)
        with np.errstate(divide="ignore", invalid="ignore"):
            beta = (h[..., 0] * f[1] - h[..., 1] * f[0]) / det
            gamma = (e[0] * h[..., 1] - e[1] * h[..., 0]) / det
            single = np.nan_to_num(np.stack([1 - beta - gamma, beta, gamma], -1), nan=0.5)
        own = np.asarray(mapping.barycentric(seen, np.stack([a, b, c]))[0])
        for picture, title in ((single, "2 x 2 inverse, singles"), (own, "barycentric")):
            colour = np.where(inside[..., None], np.clip(picture, 0, 1), 0.97)
            panels.append(Panel(_codes(colour), title, f"height {0.6 * thin:g}"))
    told.append(_said(lambda: mapping.barycentric(np.zeros(2), np.array([[0.0, 0], [1, 1], [2, 2]]))))
    return panels, told


def _pair(name: str, title: str, text: str, made: tuple[list[Panel], list[str]], width: int = 4) -> Figure:
    panels, told = made
    return Figure(name, title, text, [panels[i : i + width] for i in range(0, len(panels), width)], told)


FAILURES: dict[str, Callable[[int], Figure]] = {
    "fails_poles": lambda n: Figure(
        "fails_poles",
        "Poles",
        "Around a pole u runs through all its values within a pixel. Its derivative is +∞ there by rule, and "
        "filters answer with the ring's average.",
        _poles(n),
    ),
    "fails_seam": lambda n: Figure(
        "fails_seam",
        "The seam",
        "Where u returns from 1 to 0, differences between pixels see a jump of a whole turn.",
        _seam(n),
    ),
    "fails_axis": lambda n: Figure(
        "fails_axis",
        "On the axis, at the centroid",
        "Points on a cylinder's axis have no longitude, the centroid has no direction.",
        _axis(n),
    ),
    "fails_misses": lambda n: Figure(
        "fails_misses",
        "Reflected rays that miss",
        "A ray that leaves without meeting the intermediate surface has no coordinate: NaN, coverage 0, grey.",
        _misses(n),
    ),
    "fails_edges": lambda n: Figure(
        "fails_edges",
        "Edges and corners of a cube",
        "A face that is read by itself ends half a texel before its edge.",
        _edges(n),
    ),
    "fails_projector": lambda n: Figure(
        "fails_projector",
        "Behind a projector, and on backs",
        "Division by q alone throws a second, turned picture behind the projector.",
        _projectors(n),
    ),
    "fails_bounds": lambda n: _pair(
        "fails_bounds",
        "Degenerate bounds",
        "A box without width has no coordinate across it.",
        _shrinking(n),
    ),
    "fails_determinant": lambda n: _pair(
        "fails_determinant",
        "ae = bd",
        "u = as + bt + c, v = ds + et + f loses a direction as ae - bd goes to zero.",
        _determinants(n),
    ),
    "fails_slivers": lambda n: _pair(
        "fails_slivers",
        "Slivers",
        "Weights of points in ever thinner triangles, which are drawn as if they were high: red, green and blue "
        "are the weights.",
        _slivers(n),
    ),
}
