"""The examples and the README's code run as they stand."""

import re
import runpy
import shlex
from pathlib import Path

import pytest

import multum as mt
from multum.cli import main
from multum.demo.pictures import photograph

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("path", sorted((ROOT / "examples/python").glob("*.py")), ids=lambda p: p.stem)
def test_example_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    quick = {
        "lod_rules": ["--scale", "0.2", "--only", "gravel"],
        "filter_errors": ["--scale", "0.2"],
        "failures": ["--only", "codes"],
    }
    monkeypatch.setattr("sys.argv", [str(path), *quick.get(path.stem, [])])
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that the README speaks of."""
    monkeypatch.chdir(tmp_path)
    mt.write_image("photo.jpg", photograph("coffee"))
    mt.write_image("page.jpg", photograph("astronaut"))
    mt.write_image("brick.png", photograph("brick"))
    return tmp_path


def test_readme_python(workplace: Path) -> None:
    found = blocks("python")
    assert len(found) >= 4
    names: dict[str, object] = {}
    for block in found:
        exec(compile(block, "README.md", "exec"), names)


def test_readme_commands(workplace: Path) -> None:
    lines = [line for block in blocks("console") for line in block.splitlines()]
    commands = [line.removeprefix("$ ") for line in lines if line.startswith("$ multum ")]
    assert len(commands) >= 4
    for command in commands:
        words = shlex.split(command)[1:]
        assert main([*words, "--scale", "0.25"] if words == ["demo"] else words) == 0


def test_readme_points_at_files_that_are_there() -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), target
