"""Image files: round trips, damaged and hostile files, and nothing left behind."""

from __future__ import annotations

import io
import resource
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]
ROUND_TRIPS = [
    *[
        (ext, dtype, c)
        for ext in ("png", "tif", "tiff")
        for dtype in ("uint8", "uint16")
        for c in (1, 2, 3, 4)
        if ext == "png" or c != 2
    ],
    ("tif", "float32", 3),
    ("tif", "float32", 4),
    ("exr", "float32", 3),
    ("exr", "float32", 4),
]


def noise(dtype: str, channels: int, size: tuple[int, int] = (13, 21)) -> Array:
    rng = np.random.default_rng(channels)
    shape = size if channels == 1 else (*size, channels)
    if dtype.startswith("f"):
        return rng.normal(0, 10, shape).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


@pytest.mark.parametrize(("extension", "dtype", "channels"), ROUND_TRIPS)
def test_round_trips_are_exact(extension: str, dtype: str, channels: int, tmp_path: Path) -> None:
    image = noise(dtype, channels)
    path = tmp_path / f"picture.{extension}"
    mt.write_image(path, image)
    back = mt.read_image(path)
    assert back.dtype == image.dtype
    np.testing.assert_array_equal(back, image)
    info = mt.image_info(path)
    assert (info.width, info.height, info.channels, info.dtype) == (21, 13, channels, image.dtype)
    texture = mt.Texture.open(path)
    assert (texture.width, texture.height, texture.channels) == (21, 13, channels)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_round_trips_with_loss(tmp_path: Path) -> None:
    y, x = np.mgrid[:64, :80]
    smooth = np.stack([x * 3, y * 3, 255 - x - y], -1).astype(np.uint8)
    mt.write_image(tmp_path / "a.jpg", smooth)
    difference = np.abs(mt.read_image(tmp_path / "a.jpg").astype(int) - smooth)
    assert difference.mean() < 3
    light = np.exp(np.random.default_rng(0).normal(0, 3, (16, 16, 3))).astype(np.float32)
    mt.write_image(tmp_path / "a.hdr", light)
    # Eight bits of mantissa, shared by a pixel's channels, rounded down.
    assert (np.abs(mt.read_image(tmp_path / "a.hdr") - light) <= light.max(-1, keepdims=True) / 127).all()


@pytest.mark.parametrize("extension", ["png", "tif", "jpg"])
def test_other_libraries_see_the_same(extension: str, tmp_path: Path) -> None:
    # Smooth, because decoders interpolate a JPEG's half-size colours in different ways.
    y, x = np.mgrid[:64, :80]
    image = np.stack([x + y, 200 - x, 90 + y], -1).astype(np.uint8)
    mine, theirs = tmp_path / f"mine.{extension}", tmp_path / f"theirs.{extension}"
    mt.write_image(mine, image)
    cv2.imwrite(str(theirs), image[..., ::-1])
    seen = np.asarray(cv2.imread(str(mine), cv2.IMREAD_COLOR))[..., ::-1]
    # Two decoders of the same JPEG differ by their inverse transforms and colour rounding.
    slack = 0 if extension != "jpg" else 4
    assert np.abs(seen.astype(int) - mt.read_image(mine)).max() <= slack
    other = np.asarray(cv2.imread(str(theirs), cv2.IMREAD_COLOR))[..., ::-1]
    assert np.abs(other.astype(int) - mt.read_image(theirs)).max() <= slack


def encoded(tmp_path: Path) -> dict[str, bytes]:
    """One small file of each format."""
    files = {}
    for name, image in {
        "a.png": noise("uint8", 3),
        "b.png": noise("uint16", 4),
        "a.jpg": noise("uint8", 3),
        "a.tif": noise("uint16", 3),
        "a.hdr": np.abs(noise("float32", 3)),
        "a.exr": noise("float32", 4),
    }.items():
        path = tmp_path / name
        mt.write_image(path, image)
        files[name] = path.read_bytes()
    return files


def test_truncated_and_damaged_files(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for name, data in encoded(tmp_path).items():
        path = tmp_path / f"broken-{name}"
        for length in {0, 1, 3, 8, 20, *np.linspace(0, len(data) - 1, 25).astype(int).tolist()}:
            path.write_bytes(data[:length])
            attempt(path)
            if length < len(data) // 2 and not name.endswith("jpg"):
                # Half a picture is no picture; only JPEG decoders go on without the rest.
                with pytest.raises(OSError, match="broken"):
                    mt.read_image(path)
        for _ in range(40):
            damaged = bytearray(data)
            for at in rng.integers(0, len(data), 3):
                damaged[at] = int(rng.integers(0, 256))
            path.write_bytes(damaged)
            attempt(path)
        # The header of this format, and noise from there on.
        path.write_bytes(data[:64] + rng.bytes(2000))
        attempt(path)
    for length in (0, 1, 100, 10_000):
        path = tmp_path / "noise.png"
        path.write_bytes(rng.bytes(length))
        with pytest.raises(OSError, match=r"noise\.png"):
            mt.read_image(path)
        with pytest.raises(OSError, match=r"noise\.png"):
            mt.image_info(path)


def attempt(path: Path) -> None:
    """An image or an OSError, soon."""
    start = time.monotonic()
    try:
        assert mt.read_image(path).size > 0
    except OSError as error:
        message = str(error)
    else:
        message = path.name
    assert path.name in message
    assert time.monotonic() - start < 2


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def hostile_files() -> dict[str, bytes]:
    """Short files that claim 60000 x 60000 pixels or more."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 60_000, 60_000, 8, 2, 0, 0, 0))
    deep = chunk(b"IHDR", struct.pack(">IIBBBBB", 60_000, 60_000, 16, 6, 0, 0, 1))
    largest = chunk(b"IHDR", struct.pack(">IIBBBBB", 2**31 - 1, 2**31 - 1, 8, 6, 0, 0, 0))
    some = chunk(b"IDAT", zlib.compress(bytes(20)))
    bomb = chunk(b"IDAT", zlib.compress(bytes(3_000_000), 9))
    end = chunk(b"IEND", b"")
    magic = b"\x89PNG\r\n\x1a\n"
    text = chunk(b"zTXt", b"k\0\0" + zlib.compress(bytes(200_000_000), 9))
    one = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)) + chunk(
        b"IDAT", zlib.compress(b"\0\0")
    )
    entries = [
        (256, 4, 60_000),
        (257, 4, 60_000),
        (258, 3, 8),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 8),
        (277, 3, 1),
        (278, 4, 60_000),
        (279, 4, 2**31),
    ]
    tiff = b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(entries))
    tiff += b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in entries) + bytes(4)
    many = (
        b"II*\0"
        + struct.pack("<I", 8)
        + struct.pack("<H", 1)
        + struct.pack("<HHII", 258, 3, 2**32 - 1, 8)
        + bytes(4)
    )
    jpeg = bytes.fromhex("ffd8ffc0001108ffffffff03012200021101031101ffda000c03010002110311003f00")
    hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n" + bytes(20)
    return {
        "short.png": magic + header + some + end,
        "deep.png": magic + deep + some + end,
        "largest.png": magic + largest + some + end,
        "bomb.png": magic + header + bomb + end,
        "text.png": magic + text + one + end,
        "huge.tif": tiff,
        "many.tif": many,
        "huge.jpg": jpeg,
        "huge.hdr": hdr,
    }


def test_hostile_files_end_soon_and_small(tmp_path: Path) -> None:
    """Each in at most a second and half a gigabyte of address space beyond what the process has."""
    for name, data in hostile_files().items():
        path = tmp_path / name
        path.write_bytes(data)
        code = (
            "import multum as mt, resource, sys\n"
            "held = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
            "resource.setrlimit(resource.RLIMIT_AS, (held + (512 << 20),) * 2)\n"
            "for read in (mt.image_info, mt.read_image):\n"
            "    try:\n        print('read', len(read(sys.argv[1])))\n"
            "    except OSError as error:\n        print('OSError', error)\n"
        )
        start = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-c", code, str(path)], capture_output=True, text=True, timeout=60, check=False
        )
        assert done.returncode == 0, (name, done.stderr[-500:])
        lines = done.stdout.splitlines()
        assert len(lines) == 2, (name, lines)
        # The text chunk's picture of one pixel may be read; none of the others is a picture.
        assert lines[1].startswith("OSError") or name == "text.png", (name, lines)
        assert time.monotonic() - start < 5, name


def test_a_refused_write_leaves_nothing_behind(tmp_path: Path) -> None:
    image = noise("uint8", 3)
    with pytest.raises(FileNotFoundError):
        mt.write_image(tmp_path / "missing" / "a.png", image)
    for name, array in (
        ("a.jpg", noise("uint16", 3)),
        ("a.hdr", image),
        ("a.exr", noise("float32", 1)),
        ("a.png", noise("float32", 3)),
    ):
        with pytest.raises(ValueError, match=r"^image: "):
            mt.write_image(tmp_path / name, array)
    for name in ("a.bmp", "a", "a.png.exe", ".png"):
        with pytest.raises(ValueError, match=r"^path: "):
            mt.write_image(tmp_path / name, image)
    with pytest.raises(ValueError, match=r"^image: "):
        mt.write_image(tmp_path / "a.tif", noise("uint8", 2))
    with pytest.raises(ValueError, match=r"^image: "):
        mt.write_image(tmp_path / "a.png", noise("uint8", 4)[..., :0])
    folder = tmp_path / "folder.png"
    folder.mkdir()
    with pytest.raises(OSError, match=r"folder\.png"):
        mt.write_image(folder, image)
    with pytest.raises(OSError, match="folder"):
        mt.read_image(folder)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.png"]
    assert not list(folder.iterdir())


def test_a_write_replaces_the_file_or_leaves_it(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    mt.write_image(path, noise("uint8", 1))
    mt.write_image(path, noise("uint8", 3))
    before = path.read_bytes()
    with pytest.raises(ValueError, match=r"^image: "):
        mt.write_image(path, noise("float32", 3))
    assert path.read_bytes() == before


def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path: Path) -> None:
    code = (
        "import multum as mt, numpy as np, resource, signal, sys, os\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n    mt.write_image(sys.argv[1], np.random.default_rng(0).integers(0, 255, (99, 99), np.uint8))\n"
        "except OSError as error:\n    print('OSError', os.listdir(os.path.dirname(sys.argv[1])))\n"
    )
    run = [sys.executable, "-c", code, str(tmp_path / "a.png")]
    assert subprocess.run(run, capture_output=True, text=True, check=True).stdout == "OSError []\n"
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 1000


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_turned_upright(orientation: int, tmp_path: Path) -> None:
    """EXIF orientations as the standard's table tells where row 0 and column 0 are."""
    upright = np.zeros((16, 24), np.uint8)
    upright[:8, :8] = 255
    upright[:8, 8:16] = 160
    upright[8:, :8] = 80
    stored = {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: upright.T,
        6: np.rot90(upright, 1),
        7: upright[::-1, ::-1].T,
        8: np.rot90(upright, -1),
    }[orientation]
    path = tmp_path / "a.jpg"
    cv2.imwrite(str(path), np.ascontiguousarray(stored), [cv2.IMWRITE_JPEG_QUALITY, 100])
    exif = b"Exif\0\0MM\0*" + struct.pack(">IHHHIHHI", 8, 1, 0x112, 3, 1, orientation, 0, 0)
    data = path.read_bytes()
    path.write_bytes(data[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + data[2:])
    seen = mt.read_image(path)
    assert seen.shape == upright.shape
    assert np.abs(seen.astype(int) - upright).max() < 20


def test_odd_paths(tmp_path: Path) -> None:
    for path in (tmp_path / "nothing.png", tmp_path / ("x" * 300 + ".png"), "a\0b.png"):
        with pytest.raises(OSError):  # noqa: PT011
            mt.read_image(path)
    unnamed: Any = io.BytesIO()
    with pytest.raises(TypeError):
        mt.read_image(unnamed)
    name = tmp_path / "Bild mit Ä und 图.PNG"
    mt.write_image(name, noise("uint8", 1))
    assert mt.read_image(str(name)).shape == (13, 21)
