"""Baked maps beside others: rays a second, the asteroid's own maps, and what its pictures show.

    python benches/peers/bake.py [FOLDER]

FOLDER holds asteroid-high.obj, asteroid-low.obj and the maps that ship with them (glmark2-data); without it a
generated ball is used and there is nothing to compare the maps with. Rays of other libraries need embreex or
open3d. Times are minima of five runs.
"""

import importlib.util
import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import multum as mt

SIZE = 1024


def ball(rings: int, bump: float) -> mt.Mesh:
    """A bumpy sphere of 4 rings^2 faces."""
    v, u = np.meshgrid(
        np.linspace(0, math.pi, rings + 1), np.arange(2 * rings) * math.pi / rings, indexing="ij"
    )
    r = 1 + bump * np.sin(16 * u) * np.sin(v) ** 2 * np.cos(15 * v)
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1) * r[..., None]
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
    c, d = a + 2 * rings, b + 2 * rings
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, d), (a, d, b))])
    # The first and the last row are the poles, one vertex each.
    faces = np.where(faces < 2 * rings, 0, np.minimum(faces, 2 * rings * rings))
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    return mt.Mesh.build(points.reshape(-1, 3), faces)


def fastest(work: Callable[[], Any], runs: int = 5) -> float:
    """Seconds of the fastest run."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def rays(high: mt.Mesh, low: mt.Mesh) -> None:
    """First hits of the same rays, the tree built anew each time and, where a library can, only once."""
    rng = np.random.default_rng(0)
    face = rng.integers(0, len(low.faces), 1_000_000)
    weights = rng.dirichlet([1, 1, 1], len(face))
    corners = low.faces[face]
    point = np.einsum("nc,nck->nk", weights, low.positions[corners].astype(np.float64))
    normal = np.einsum("nc,nck->nk", weights, low.normals[corners].astype(np.float64))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    extent = float(np.ptp(high.positions, axis=0).max())
    origin = point + 0.1 * extent * normal
    build = fastest(lambda: mt.bake.intersect(high, origin[:1], -normal[:1]))
    for threads in (1, 2):
        whole = fastest(lambda n=threads: mt.bake.intersect(high, origin, -normal, threads=n))
        rate = len(face) / (whole - build) / 1e6
        print(f"multum, {threads} threads: {rate:.2f} M rays/s, tree {build * 1e3:.0f} ms")
    ours = mt.bake.intersect(high, origin, -normal)[0]
    if importlib.util.find_spec("embreex"):
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh

        def scene() -> Any:
            made = rtcore_scene.EmbreeScene()
            TriangleMesh(made, high.positions, high.faces.astype(np.int32))
            made.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
            return made

        built = scene()
        o, d = origin.astype(np.float32), (-normal).astype(np.float32)
        whole = fastest(lambda: built.run(o, d))
        same = (built.run(o, d) == ours).mean()
        print(
            f"embreex, as it comes: {len(face) / whole / 1e6:.2f} M rays/s, tree {fastest(scene) * 1e3:.0f} ms, "
            f"same face in {100 * same:.3f} %"
        )
    if importlib.util.find_spec("open3d"):
        import open3d as o3d

        o3d_scene = o3d.t.geometry.RaycastingScene()
        o3d_scene.add_triangles(high.positions, high.faces)
        both = np.concatenate([origin, -normal], 1).astype(np.float32)
        whole = fastest(lambda: o3d_scene.cast_rays(both))
        print(f"open3d: {len(face) / whole / 1e6:.2f} M rays/s")


def speed(high: mt.Mesh, low: mt.Mesh) -> None:
    """Whole bakes, from meshes to codes."""
    for samples in (1, 2, 3):
        for method in ("outermost", "closest"):
            found: list[mt.bake.Map] = []

            def work(n: int = samples, m: str = method, out: list[mt.bake.Map] = found) -> None:
                out.append(mt.bake.normal_map(high, low, SIZE, samples=n, method=m))

            seconds = fastest(work, 3)
            report = found[-1].report
            assert report is not None
            print(
                f"{len(high.faces)} faces to {SIZE}^2, {samples}x{samples} samples, {method}: {seconds:.2f} s, "
                f"{report.covered} texels, {report.rays / seconds / 1e6:.2f} M samples/s"
            )


def shipped(folder: Path, high: mt.Mesh, low: mt.Mesh) -> None:
    """The maps that come with the model against ours, and the pictures both give against the detailed mesh."""
    islands = mt.read_image(folder / "asteroid-height-map.png")[..., 1] > 127
    print("space    | mean cosine | angle: median, 90 %, 99 % | at edges of islands: mean, inside: mean")
    for space, name in (("object", ""), ("tangent", "-tangent")):
        theirs = mt.read_image(folder / f"asteroid-normal-map{name}.png")[..., :3] / 127.5 - 1.0
        theirs /= np.linalg.norm(theirs, axis=-1, keepdims=True)
        baked = mt.bake.normal_map(high, low, SIZE, space=space, dtype="float32")
        report = baked.report
        assert report is not None
        both = ((report.flags & mt.bake.COVERED) > 0) & islands
        cosine = ((2.0 * np.asarray(baked) - 1.0) * theirs).sum(-1)
        angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
        deep = both.copy()
        for axis in (0, 1):
            for step in range(-4, 5):
                deep &= np.roll(both, step, axis)
        edge = both & ~deep
        low_end, middle, high_end = np.percentile(angle[both], [50, 90, 99])
        print(
            f"{space:8} | {cosine[both].mean():.5f} | {low_end:.2f} {middle:.2f} {high_end:.2f} deg | "
            f"{angle[edge].mean():.2f} deg ({edge.sum()} texels), {angle[deep].mean():.2f} deg"
        )
    normal = mt.TextureSlot(0, encoding="normal", wrap=("clamp", "clamp"))
    dressed = {"without a map": replace(low, materials=[mt.Material()])}
    maps = {
        "shipped map": mt.read_image(folder / "asteroid-normal-map-tangent.png")[..., :3],
        "our map": np.asarray(mt.bake.normal_map(high, low, SIZE)),
    }
    for name, pixels in maps.items():
        images = [mt.MeshImage(name, pixels=pixels)]
        dressed[name] = replace(low, materials=[mt.Material(normal_texture=normal)], images=images)
    bare = replace(high, materials=[mt.Material()])
    print(
        "pictures of the simple mesh against pictures of the detailed one, rms of linear light, eight views:"
    )
    lit = [mt.light.Directional((-0.4, -0.5, -0.7), (1.0, 1.0, 1.0))]
    errors: dict[tuple[str, int], list[float]] = {}
    for width in (512, 128, 32):
        for view in range(8):
            turn = view * math.pi / 4
            extent = float(np.ptp(high.positions, axis=0).max())
            centre = mt.Scene(bare).center
            eye = centre + 1.8 * extent * np.array([math.cos(turn), 0.4 * math.sin(3 * turn), math.sin(turn)])
            camera = mt.Camera(eye, centre, fov=40)

            def draw(mesh: mt.Mesh, at: mt.Camera = camera, n: int = width) -> Any:
                return mt.render(mt.Scene(mesh), at, (n, n), output="linear", lights=lit, supersample=4)

            truth = draw(bare)
            for name, mesh in dressed.items():
                picture = draw(mesh)
                inside = (truth[..., 3] > 0.999) & (picture[..., 3] > 0.999)
                difference = (picture - truth)[inside][:, 0].astype(np.float64)
                errors.setdefault((name, width), []).append(float((difference**2).mean()))
    for (name, width), values in errors.items():
        print(f"  {width:4} pixels, {name:14}: {math.sqrt(float(np.mean(values))):.4f}")


def main() -> None:
    """Print everything."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    if folder is None:
        high = ball(110, 0.02)
        low = ball(110, 0.02).simplify(0.01).unwrap(SIZE)
    else:
        high = mt.Mesh.open(folder / "asteroid-high.obj")
        low = mt.Mesh.open(folder / "asteroid-low.obj")
    rays(high, low)
    speed(high, low)
    if folder is not None:
        shipped(folder, high, low)


if __name__ == "__main__":
    main()
