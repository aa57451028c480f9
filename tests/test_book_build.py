"""What the book's build adds to Sphinx: the name of the execution cache, and the figures of executed notebooks."""

import base64
import importlib.util
import json
import os
import re
from pathlib import Path

import pytest

BOOK = Path(__file__).resolve().parents[1] / "book"


def load(path: Path):
    """A module of the book's folder, which is not a package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


build = load(BOOK / "_ext" / "fogkit_book.py")
figures = load(BOOK / "figures.py")


@pytest.fixture
def tree(tmp_path):
    """The least that a fingerprint is taken of."""
    for name in ("requirements.lock", "src/fogkit/units.py", "data/claims/paper.csv", "book/_ext/fogkit_book.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("name", ["requirements.lock", "src/fogkit/units.py", "data/claims/paper.csv"])
def test_fingerprint_changes_with_what_a_cell_can_depend_on(tree, name):
    before = build.fingerprint(tree)
    (tree / name).write_text("changed", encoding="utf-8")
    assert build.fingerprint(tree) != before


def test_fingerprint_changes_when_a_file_comes_or_moves(tree):
    seen = {build.fingerprint(tree)}
    (tree / "data" / "new.csv").write_text("", encoding="utf-8")
    seen.add(build.fingerprint(tree))
    (tree / "data" / "new.csv").rename(tree / "data" / "newer.csv")
    seen.add(build.fingerprint(tree))
    assert len(seen) == 3


def test_fingerprint_does_not_change_with_compiled_files_or_chapters(tree):
    before = build.fingerprint(tree)
    for name in ("src/fogkit/__pycache__/units.pyc", "book/chapter.md"):
        (tree / name).parent.mkdir(exist_ok=True)
        (tree / name).write_text("x", encoding="utf-8")
    assert build.fingerprint(tree) == before


def test_old_caches_are_removed(tmp_path):
    pytest.importorskip("jupyter_cache")
    for age, name in enumerate(("newest", "older", "old", "oldest")):
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    cache = build.open_cache(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {cache.name, "newest", "older"}


def notebook(path: Path, *cells: tuple[dict, int]) -> Path:
    """A notebook of cells ``(metadata, number of images that it shows)``."""
    image = {"data": {"image/png": base64.b64encode(b"png").decode(), "image/svg+xml": ["<svg", "/>"]}}
    cells = [{"metadata": metadata, "outputs": [image] * count} for metadata, count in cells]
    path.write_text(json.dumps({"cells": cells}), encoding="utf-8")
    return path


def label(name: str) -> dict:
    return {"mystnb": {"figure": {"name": name}}}


def test_figures_are_written_in_both_formats_under_their_labels(tmp_path, monkeypatch, capsys):
    (tmp_path / "notebooks").mkdir()
    notebook(tmp_path / "notebooks" / "a.ipynb", ({}, 0), (label("fig-one"), 1), (label("fig-two"), 1))
    for name, path in (("ROOT", tmp_path), ("NOTEBOOKS", tmp_path / "notebooks"), ("FIGURES", tmp_path / "figures")):
        monkeypatch.setattr(figures, name, path)
    assert figures.main() == 0
    written = {p.name: p.read_bytes() for p in (tmp_path / "figures").iterdir()}
    contents = {"png": b"png", "svg": b"<svg/>"}
    assert written == {f"fig-{n}.{kind}": content for n in ("one", "two") for kind, content in contents.items()}
    assert "2 figures from 1 pages" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        (({}, 1), "a figure has no label"),
        ((label("fig-a"), 0), "it draws 0"),
        ((label("fig-a"), 2), "it draws 2"),
    ],
)
def test_figures_without_a_label_or_a_picture_are_refused(tmp_path, cell, message):
    with pytest.raises(ValueError, match=message):
        figures.figures(notebook(tmp_path / "a.ipynb", cell))


def test_the_pictures_of_the_readme_are_there():
    root = BOOK.parent
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", (root / "README.md").read_text(encoding="utf-8"))
    assert pictures and all((root / picture).is_file() for picture in pictures)
