"""What the book's build adds to Sphinx: the cache of executed notebooks, their execution, and their figures."""

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


@pytest.fixture
def executions(tmp_path, monkeypatch):
    """Two at a time, with an executor that takes no kernel: a cell that says `raise` fails, any other prints itself."""
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_nb")
    from jupyter_cache import get_cache
    from jupyter_cache.executors import utils

    def execute(notebook, cwd, timeout, allow_errors):
        cell = notebook.cells[-1]
        cell.outputs = [nbformat.v4.new_output("stream", text=cell.source)]
        return utils.ExecutionResult(notebook, cwd, 1.0, err=RuntimeError() if "raise" in cell.source else None)

    nbformat = pytest.importorskip("nbformat")
    monkeypatch.setattr(utils, "single_nb_execution", execute)
    execution = load(BOOK / "_ext" / "fogkit_execution.py")
    running = execution.Executions(get_cache(tmp_path / "cache"), timeout=60, workers=2)
    yield execution, running, lambda code: nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(code)])
    running.cancel()


def test_only_what_was_executed_without_an_error_is_kept(executions, tmp_path):
    from jupyter_cache import get_cache

    _, running, make = executions
    cache = get_cache(tmp_path / "cache")
    for name, code in (("good", "1"), ("bad", "raise"), ("unread", "2")):
        running.start(name, tmp_path / f"{name}.md", make(code))
    for name in ("good", "bad", "page without cells"):
        running.finish(name)
    assert cache.merge_match_into_notebook(make("1"))[1].cells[0].outputs[0].text == "1"
    for code in ("raise", "2"):
        with pytest.raises(KeyError):
            cache.match_cache_notebook(make(code))


def test_only_notebooks_that_the_cache_does_not_hold_are_stale(executions, tmp_path):
    from jupyter_cache import get_cache
    from myst_nb.core.config import NbParserConfig
    from myst_parser.config.main import MdParserConfig

    execution, running, _ = executions
    head = "---\njupytext:\n  text_representation:\n    format_name: myst\nkernelspec:\n  name: python3\n---\n"
    cells = {name: head + f"# {name}\n\n```{{code-cell}} ipython3\n{name}\n```\n" for name in ("kept", "new")}
    paths = {name: tmp_path / f"{name}.md" for name in ("kept", "new", "prose")}
    for name, path in paths.items():
        path.write_text(cells.get(name, "# Prose\n"), encoding="utf-8")

    def stale():
        cache = get_cache(tmp_path / "cache")
        return execution.stale_notebooks(paths, MdParserConfig(), NbParserConfig(), cache)

    found = stale()
    assert set(found) == {"kept", "new"}
    running.start("kept", paths["kept"], found["kept"])
    running.finish("kept")
    assert set(stale()) == {"new"}
    paths["kept"].write_text(cells["kept"].replace("\nkept\n", "\nedited\n"), encoding="utf-8")
    assert set(stale()) == {"kept", "new"}
    assert execution.seconds_before(tmp_path) == {str(paths["kept"]): 1.0}


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
