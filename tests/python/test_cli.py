"""The command line: real work on files of every format, and plain words for mistakes."""

import io
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum import reference
from multum.cli import main, parser
from multum.cli.convert import fit
from multum.cli.progress import Progress
from multum.cli.warp import corners_matrix


def picture(dtype: Any = np.uint8, channels: int = 3, size: tuple[int, int] = (24, 32)) -> NDArray[Any]:
    """A smooth picture that uses the whole range."""
    y, x = np.mgrid[: size[0], : size[1]].astype(np.float64)
    planes = [0.5 + 0.5 * np.sin(x / (3 + c) + y / (5 - c)) for c in range(channels)]
    share = np.stack(planes, axis=2) if channels > 1 else planes[0]
    if np.dtype(dtype).kind == "f":
        return share.astype(dtype)
    return np.floor(share * np.iinfo(dtype).max + 0.5).astype(dtype)


def run(*arguments: object) -> int:
    return main([str(a) for a in arguments])


@pytest.mark.parametrize(
    ("name", "image"),
    [
        ("a.png", picture(np.uint8)),
        ("b.png", picture(np.uint16, 1)),
        ("c.png", picture(np.uint16, 4)),
        ("d.tif", picture(np.uint16, 3)),
        ("e.tiff", picture(np.float32, 3)),
        ("f.exr", picture(np.float32, 3)),
        ("g.exr", picture(np.float32, 4)),
    ],
)
def test_identity_keeps_every_number_and_the_dtype(tmp_path: Path, name: str, image: NDArray[Any]) -> None:
    source, target = tmp_path / name, tmp_path / f"out-{name}"
    mt.write_image(source, image)
    assert run("warp", source, target, "--matrix", 1, 0, 0, 0, 1, 0) == 0
    made = mt.read_image(target)
    assert made.dtype == image.dtype
    np.testing.assert_array_equal(made, image)


def test_matrix_forms_agree_with_opencv(tmp_path: Path) -> None:
    image = picture()
    source, target = tmp_path / "in.png", tmp_path / "out.png"
    mt.write_image(source, image)
    rows = [[0.8, -0.2, 3.0], [0.1, 0.7, -1e-3]]
    expected = cv2.warpAffine(image, np.array(rows), (40, 30), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    np.save(tmp_path / "m.npy", rows)
    (tmp_path / "m.txt").write_text("0.8, -0.2, 3\n0.1 0.7 -1e-3\n")
    flat = [v for row in rows for v in row]
    forward = np.linalg.inv(np.array([*rows, [0.0, 0.0, 1.0]])).ravel().tolist()
    for given in (
        flat,
        ["0.8,-0.2,3", "0.1,0.7,-1e-3"],
        [tmp_path / "m.npy"],
        [tmp_path / "m.txt"],
        [*forward, "--forward"],
    ):
        assert run("warp", source, target, "--size", "40x30", "--filter", "bilinear", "--matrix", *given) == 0
        assert np.abs(mt.read_image(target).astype(int) - expected).max() <= 1


def test_a_map_and_its_wrap_modes(tmp_path: Path) -> None:
    image = picture(np.uint16)
    mt.write_image(tmp_path / "in.png", image)
    y, x = np.mgrid[:24, :32].astype(np.float64)
    np.save(tmp_path / "map.npy", np.stack([x + 32, y - 48], axis=2))
    assert (
        run(
            "warp",
            tmp_path / "in.png",
            tmp_path / "out.png",
            "--map",
            tmp_path / "map.npy",
            "--wrap",
            "repeat",
        )
        == 0
    )
    np.testing.assert_array_equal(mt.read_image(tmp_path / "out.png"), image)
    code = run(
        *("warp", tmp_path / "in.png", tmp_path / "out.png", "--map", tmp_path / "map.npy"),
        *("--wrap", "repeat", "border", "--border", 1, 2, 65535),
    )
    assert code == 0
    assert (mt.read_image(tmp_path / "out.png") == [1, 2, 65535]).all()


def test_corners_are_those_of_opencv() -> None:
    corners = [90.0, 40.0, 610.0, 80.0, 640.0, 900.0, 60.0, 860.0]
    target = np.array([[0, 0], [599, 0], [599, 849], [0, 849]], np.float32)
    expected = cv2.getPerspectiveTransform(target, np.array(corners, np.float32).reshape(4, 2))
    np.testing.assert_allclose(corners_matrix(corners, (850, 600)), expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("how", [["--size", "8x6"], ["--scale", "0.25"]])
def test_resize_averages_light_where_asked(tmp_path: Path, how: list[str]) -> None:
    y, x = np.mgrid[:24, :32]
    mt.write_image(tmp_path / "in.png", np.where((x + y) % 2, 255, 0).astype(np.uint8))
    cases: list[tuple[Literal["linear", "srgb"], int]] = [("linear", 128), ("srgb", 188)]
    for encoding, value in cases:
        assert run("resize", tmp_path / "in.png", tmp_path / "out.png", *how, "--encoding", encoding) == 0
        made = mt.read_image(tmp_path / "out.png")
        assert made.shape == (6, 8)
        assert (made[1:-1, 1:-1] == value).all()
        # At the picture's rim the edge texel goes on: the integral is not quite the mean of squares there.
        matrix = np.array([[4, 0, 1.5], [0, 4, 1.5], [0, 0, 1.0]])
        light = reference.warp(
            mt.read_image(tmp_path / "in.png"), matrix, (6, 8), wrap="clamp", encoding=encoding
        )
        codes = light if encoding == "linear" else 1.055 * np.asarray(light) ** (1 / 2.4) - 0.055
        assert np.abs(made - 255 * np.asarray(codes)).max() <= 0.5 + 1e-3  # rounded to nearest


@pytest.mark.parametrize("source", ["a.png", "a.jpg", "a.tif", "a.hdr", "a.exr"])
@pytest.mark.parametrize("target", ["b.png", "b.jpg", "b.tif", "b.hdr", "b.exr"])
def test_every_format_becomes_every_other(tmp_path: Path, source: str, target: str) -> None:
    image = picture(np.float32 if source[2:] in ("hdr", "exr") else np.uint8)
    mt.write_image(tmp_path / source, image)
    assert run("resize", tmp_path / source, tmp_path / target, "--scale", 1) == 0
    made = mt.read_image(tmp_path / target)
    assert made.shape == image.shape
    back = tmp_path / "back.png"
    assert run("resize", tmp_path / target, back, "--scale", 1, "--depth", 8) == 0
    light = image if image.dtype == np.float32 else _decode(image / 255.0)
    error = np.abs(mt.read_image(back) - _codes(light))
    if "jpg" in source + target:
        # JPEG promises nothing for a single pixel.
        assert np.sqrt(np.mean(error**2)) < 16
    else:
        # RGBE: one exponent a pixel, so a step is at most 1/128 of its brightest channel; then two roundings.
        step = light.max(axis=2, keepdims=True) / 128 if "hdr" in source + target else 0.0
        assert (
            error
            <= 1.0 + np.maximum(_codes(light + step) - _codes(light), _codes(light) - _codes(light - step))
        ).all()


def _codes(light: NDArray[Any]) -> NDArray[np.float64]:
    cut = np.clip(np.asarray(light, np.float64), 0.0, 1.0)
    codes: NDArray[np.float64] = np.where(cut <= 0.0031308, 12.92 * cut, 1.055 * cut ** (1 / 2.4) - 0.055)
    return 255.0 * codes


def _decode(code: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def test_conversions_say_what_they_did(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    grey_alpha = np.array([[[0, 65535], [257 * 7, 3]]], np.uint16)
    made = fit(grey_alpha, "x.jpg", None, None)
    assert made.dtype == np.uint8
    assert made.tolist() == [[[0], [7]]]
    told = capsys.readouterr().err
    assert "16 bits became 8" in told
    assert "alpha" in told
    assert fit(np.array([[0, 255]], np.uint8), "x.png", "16", None).tolist() == [[0, 65535]]
    share = fit(np.array([[51]], np.uint8), "x.exr", None, "linear")
    np.testing.assert_allclose(share, np.full((1, 1, 3), 0.2), rtol=1e-6)
    assert fit(np.array([[np.nan, -1.0, 9.0]], np.float32), "x.png", "8", None).tolist() == [[0, 0, 255]]


def test_info_tells_the_truth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mt.write_image(tmp_path / "height.png", np.array([[357, 400, 500], [600, 700, 1040]], np.uint16))
    light = np.full((2, 3, 3), 0.5, np.float32)
    light[0, 0, 0] = np.inf
    mt.write_image(tmp_path / "light.exr", light)
    assert run("info", tmp_path / "height.png", tmp_path / "light.exr") == 0
    told = capsys.readouterr().out
    for words in ("PNG", "3 x 2 pixels", "uint16", "357 to 1040", "2, from 3x2 to 1x1", "1 not finite"):
        assert words in told


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["warp", "absent.png", "o.png", "--matrix", "1", "0", "0", "0", "1", "0"], "absent.png"),
        (["warp", "in.png", "o.gif", "--matrix", "1", "0", "0", "0", "1", "0"], ".png"),
        (["warp", "in.png", "no/o.png", "--matrix", "1", "0", "0", "0", "1", "0"], "no folder 'no'"),
        (["warp", "in.png", "o.png", "--matrix", "1", "0", "0"], "expected 6 (2x3) or 9 (3x3)"),
        (["warp", "in.png", "o.png", "--matrix", "1", "zero"], "expected 6 or 9 numbers"),
        (["warp", "in.png", "o.png", "--matrix", *"000000000", "--forward"], "no inverse"),
        (["warp", "in.png", "o.png", "--matrix", "nan", *"00000"], "finite"),
        (["warp", "in.png", "o.png", "--map", "absent.npy"], "no file 'absent.npy'"),
        (["warp", "in.png", "o.png", "--map", "in.png"], "no plain array"),
        (["warp", "in.png", "o.png", "--corners", "0,0", "1,0"], "expected 8"),
        (["warp", "in.png", "o.png", "--corners", *(["0,0"] * 4)], "on a line"),
        (["warp", "in.png", "o.png", "--map", "m.npy", "--forward"], "--matrix only"),
        (["resize", "in.png", "o.png", "--scale", "-1"], "above 0"),
        (["resize", "in.png", "o.png", "--scale", "1", "--filter", "sharpest"], "bilinear"),
        (["resize", "in.png", "o.png", "--scale", "1", "--wrap", "round"], "mirror"),
        (["resize", "in.png", "o.png", "--scale", "1", "--border", "1", "2"], "border"),
        (["resize", "in.png", "o.jpg", "--scale", "1", "--depth", "16"], "PNG and TIFF hold more"),
        (["resize", "in.png", "o.png", "--size", "4000000000x4000000000"], "expected"),
        (["info", "cut.png"], "cut.png"),
        (["info", "words.png"], "not an image"),
        (["demo", "--only", "fireworks"], "homography"),
        (["demo", "--scale", "99"], "0.2 to 4"),
    ],
)
def test_mistakes_get_words_and_code_2(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    mt.write_image("in.png", picture())
    Path("cut.png").write_bytes(Path("in.png").read_bytes()[:200])
    Path("words.png").write_text("this is no picture")
    assert main(words) == 2
    told = capsys.readouterr().err
    assert f"multum {words[0]}: error: " in told
    assert expected in told
    assert "Traceback" not in told


@pytest.mark.parametrize(
    "words", [[], ["fly"], ["resize", "a.png", "b.png"], ["resize", "a.png", "b.png", "--size", "4by4"]]
)
def test_wrong_usage_is_code_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    assert "usage: multum" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["demo", "warp", "resize", "info"])
def test_help_is_there(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([command, "--help"])
    assert stopped.value.code == 0
    assert command in capsys.readouterr().out
    assert command in parser().format_help()


def test_python_m_is_the_same() -> None:
    told = subprocess.run(
        [sys.executable, "-m", "multum", "--version"], capture_output=True, text=True, check=True
    ).stdout
    assert told == f"multum {mt.__version__}\n"


class Terminal(io.StringIO):
    """A stream that claims to be watched."""

    def isatty(self) -> bool:
        return True


def test_progress_shows_only_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("multum.cli.progress._QUIET_SECONDS", 0.0)
    quiet, watched = io.StringIO(), Terminal()
    for stream in (quiet, watched):
        with Progress(2, stream) as progress:
            progress.step("reading")
            progress.step("warping")
            while stream is watched and "1/2 warping" not in watched.getvalue():
                pass
            assert progress.line().startswith("[############............] 1/2 warping (")
    assert quiet.getvalue() == ""
    assert watched.getvalue().endswith(" \r")


def test_panorama_to_a_cube_and_back(tmp_path: Path) -> None:
    x, y = np.meshgrid((np.arange(128) + 0.5) / 128, (np.arange(64) + 0.5) / 64)
    sky = np.stack([0.5 + 0.4 * np.sin(2 * np.pi * x) * np.sin(np.pi * y), y, 0 * x], -1)
    sky = np.floor(sky * 255 + 0.5).astype(np.uint8)
    mt.write_image(tmp_path / "sky.png", sky)
    assert run("panorama", tmp_path / "sky.png", tmp_path / "cross.png", "--to", "cube", "--size", 32) == 0
    cross = mt.read_image(tmp_path / "cross.png")
    assert cross.shape == (96, 128, 3)
    assert np.array_equal(cross, mt.panorama.convert(sky, target="cube", size=32, layout="cross"))
    arguments = (
        "panorama",
        tmp_path / "cross.png",
        tmp_path / "back.png",
        "--from",
        "cube",
        "--size",
        "128x64",
    )
    assert run(*arguments) == 0
    back = mt.read_image(tmp_path / "back.png")
    assert np.abs(back.astype(int) - sky)[2:-2].max() < 12


def test_panorama_of_a_camera(tmp_path: Path) -> None:
    sky = np.zeros((64, 128, 3), np.uint8)
    sky[:, 96] = 255
    mt.write_image(tmp_path / "sky.png", sky)
    for words in (["90", "0"], [str(v) for v in mt.panorama.rotation(90).ravel()]):
        given = ("--to", "perspective", "--fov", 60, "--size", "33x21", "--rotation", *words)
        assert run("panorama", tmp_path / "sky.png", tmp_path / "view.png", *given) == 0
        view = mt.read_image(tmp_path / "view.png")
        assert view.shape == (21, 33, 3)
        # The bright column is half a texel right of where the camera looks.
        assert abs(view[10, :, 0].astype(int).argmax() - 17) <= 1
    sizes = {"fisheye": (20, 20), "probe": (20, 20), "octahedral": (20, 20), "stereographic": (20, 20)}
    for form, size in sizes.items():
        target = tmp_path / f"{form}.png"
        assert run("panorama", tmp_path / "sky.png", target, "--to", form, "--size", 20) == 0
        assert mt.read_image(target).shape[:2] == size


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--size", "12x"], "--size"),
        (["--rotation", "1", "2", "3", "4"], "--rotation"),
        (["--rotation", "a"], "expected numbers"),
        (["--from", "cube"], "square faces"),
        (["--fov", "90"], "fov"),
        (["--to", "perspective", "--fov", "190"], "fov"),
    ],
)
def test_panorama_mistakes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], text: str
) -> None:
    mt.write_image(tmp_path / "in.png", picture(size=(16, 31)))
    assert run("panorama", tmp_path / "in.png", tmp_path / "out.png", *words) == 2
    assert text in capsys.readouterr().err


def test_gallery_draws_maps_and_a_page(tmp_path: Path) -> None:
    mesh = tmp_path / "roof.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nv 1 1 1\nf 1 2 4\nf 1 4 3\n")
    names = ["spherical", "two_stage_cube"]
    assert run("gallery", "-o", tmp_path / "g", "--size", 48, "--only", *names, "--mesh", mesh) == 0
    page = (tmp_path / "g" / "index.html").read_text(encoding="utf-8")
    for name in names:
        sheet = mt.read_image(tmp_path / "g" / f"{name}.png")
        assert sheet.shape[1] > 5 * 48
        # Cells of the board and colours of the heat map, not one flat grey.
        assert len(np.unique(sheet.reshape(-1, 3), axis=0)) > 200
        assert f'src="{name}.png"' in page
    failing = ["fails_edges", "fails_misses"]
    assert run("gallery", "-o", tmp_path / "f", "--size", 64, "--only", *failing) == 0
    for name in failing:
        assert len(np.unique(mt.read_image(tmp_path / "f" / f"{name}.png").reshape(-1, 3), axis=0)) > 50
    assert run("gallery", "-o", tmp_path / "g", "--only", "mercator") == 2
    assert run("gallery", "-o", tmp_path / "g", "--size", 1) == 2
