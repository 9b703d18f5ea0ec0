"""A million triangles, and the largest picture: the same bytes for any number of threads, in bounded memory."""

import subprocess
import sys

import numpy as np

import multum as mt

LARGEST = """
import hashlib, resource, sys
import numpy as np, multum as mt

corners = np.random.default_rng(0).uniform(-1, 1, (300, 3)).astype(np.float32)
texture = np.arange(192, dtype=np.uint8).reshape(8, 8, 3)
uv = corners[:, :2] * 9
mesh = mt.Mesh.build(corners, np.arange(300).reshape(100, 3), uv=uv, texture=texture)
camera = mt.Camera((0, 0, 30))
mt.render(mt.Scene(mesh), camera, (64, 64), "trilinear")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
picture = mt.render(mt.Scene(mesh), camera, (16384, 16384), "trilinear", threads=int(sys.argv[1]))
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
middle = picture[8192 - 512 : 8192 + 512, 8192 - 512 : 8192 + 512]
assert (middle[..., 3] == 255).mean() > 0.5
print(grown, hashlib.blake2b(picture.data).hexdigest())
"""


def test_the_largest_picture_takes_little_more_memory_than_itself() -> None:
    """16384 by 16384 pixels, each size's own process: what is drawn in bands is not kept."""
    digests = set()
    for threads in (1, 3):
        command = [sys.executable, "-c", LARGEST, str(threads)]
        grown, digest = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        digests.add(digest)
        # KiB: the picture has four bytes a pixel; bands of 32 rows have some hundred bytes a pixel and thread.
        assert int(grown) < 16384 * 16384 * 4 / 1024 + threads * 32 * 16384 * 200 / 1024
    assert len(digests) == 1


def test_a_million_triangles() -> None:
    """A fine sheet before the camera: every pixel shows the triangle that its own place names."""
    n, size = 708, (500, 400)
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    points = np.stack([x * 2 / n - 1, 1 - y * 2 / n, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n))[..., None]
    # The lower left and the upper right half of each field.
    faces = (
        np.stack([first + np.array(k) for k in ([0, n + 1, n + 2], [0, n + 2, 1])], 2)
        .reshape(-1, 3)
        .astype(np.uint32)
    )
    assert len(faces) > 1_000_000
    mesh = mt.Mesh(
        positions=points,
        normals=np.tile(np.array([0, 0, 1], np.float32), (len(points), 1)),
        tangents=np.tile(np.array([1, 0, 0, 1], np.float32), (len(points), 1)),
        uv_sets=[(points[:, :2] + 1).astype(np.float32)],
        colors=None,
        faces=faces,
        face_material=np.zeros(len(faces), np.uint32),
        materials=[mt.Material(unlit=True, base_color=(1, 1, 1, 1))],
        images=[],
    )
    # The sheet's sides are the picture's height.
    camera = mt.Camera((0, 0, 1), fov=90)
    shown = mt.rasterize(camera.project(points, size), faces, size).triangle
    u = ((np.arange(size[0]) + 0.5 - size[0] / 2) / size[1] * 2 + 1) / 2 * n
    v = (np.arange(size[1]) + 0.5) / size[1] * n
    inside = (u > 0) & (u < n)
    i, j = np.floor(u).astype(int)[None], np.floor(v).astype(int)[:, None]
    upper = (u[None] - i) > (v[:, None] - j)
    expected = np.where(inside[None], 2 * (j * n + i) + upper, -1)
    # Vertices move by up to 1/512 pixel either way: places nearer to an edge than that may fall to either side.
    near = 1 / 256 * n / size[1]
    fu, fv = (u - np.floor(u))[None], (v - np.floor(v))[:, None]
    clear = (np.minimum(fu, 1 - fu) > near) & (np.minimum(fv, 1 - fv) > near) & (np.abs(fu - fv) > 2 * near)
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(shown[clear], expected[clear])
    pictures = [mt.render(mt.Scene(mesh), camera, size, threads=k) for k in (1, 2, 5)]
    assert (pictures[0][..., 3] == np.where(inside, 255, 0)).all()
    np.testing.assert_array_equal(pictures[0], pictures[1])
    np.testing.assert_array_equal(pictures[0], pictures[2])
