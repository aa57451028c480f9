"""What this book needs of Sphinx beyond `_config.yml`: executed cells that are never stale, figures in two formats,
executed notebooks to download, and docstrings that cite the reference list of their module. The notebooks are executed
by `fogkit_execution.py`.

The execution cache of MyST-NB is keyed on the cells alone: after an edit in `src` or `data` nothing would be run again,
and the old numbers would stay on the pages. The cache therefore lives in a folder named after a hash of all that a cell
can depend on.
"""

import hashlib
import os
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CACHES = ROOT / "build" / "cache"
KEPT = 3  # caches that stay on disk, so that going back to another branch costs nothing

KERNEL_PROFILE = """\
c = get_config()
c.IPKernelApp.log_level = "ERROR"
c.HistoryManager.enabled = False
c.InlineBackend.figure_formats = {"svg", "png"}  # svg on the page, both from `make figures`
c.InlineBackend.rc = {"svg.hashsalt": "fogkit"}  # the same figure gives the same file, without the time of its making
c.InteractiveShellApp.exec_lines = ["__import__('os').environ['SOURCE_DATE_EPOCH'] = '0'"]
"""


def fingerprint(root: Path = ROOT) -> str:
    """Hash of the package, the data, the pinned versions and the interpreter: what the output of a cell depends on."""
    digest = hashlib.sha256(f"python {sys.version_info.major}.{sys.version_info.minor}".encode())
    files = [root / "requirements.lock"]
    for folder in ("src", "data", "book/_ext"):
        files += sorted(p for p in (root / folder).rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    for path in files:
        digest.update(f"\n{path.relative_to(root).as_posix()} {hashlib.sha256(path.read_bytes()).hexdigest()}".encode())
    return digest.hexdigest()[:16]


def open_cache(caches: Path = CACHES) -> Path:
    """Folder of the execution cache that belongs to the present sources; the oldest of the others are removed."""
    from jupyter_cache import get_cache

    cache = caches / fingerprint()
    cache.mkdir(parents=True, exist_ok=True)
    os.utime(cache)
    get_cache(cache).list_cache_records()  # made here: its first use creates it
    others = sorted((p for p in caches.iterdir() if p != cache), key=lambda p: p.stat().st_mtime, reverse=True)
    for old in others[KEPT - 1 :]:
        shutil.rmtree(old, ignore_errors=True)
    return cache


def write_kernel_profile(folder: Path = ROOT / "build" / "ipython") -> Path:
    """The settings with which every cell is run; the reader's own IPython profile has no say in the book's figures."""
    profile = folder / "profile_default" / "ipython_kernel_config.py"
    profile.parent.mkdir(parents=True, exist_ok=True)
    profile.write_text(KERNEL_PROFILE, encoding="utf-8")
    return folder


def configure(app, config) -> None:
    config.nb_execution_cache_path = str(open_cache())
    os.environ["IPYTHONDIR"] = str(write_kernel_profile())


def offer_notebook(app, pagename, templatename, context, doctree) -> None:
    """Put the executed notebook of a page beside its source, for the theme's download button and for `figures.py`.

    MyST-NB leaves a notebook of every page, but without its outputs when they came from the cache.
    """
    import nbformat
    from jupyter_cache import get_cache

    page = Path(app.outdir).parent / "jupyter_execute" / f"{pagename}.ipynb"
    if doctree is None or not page.is_file():
        return
    notebook = nbformat.read(page, nbformat.NO_CONVERT)
    if any(cell.cell_type == "code" for cell in notebook.cells):
        _, executed = get_cache(app.config.nb_execution_cache_path).merge_match_into_notebook(notebook)
        target = Path(app.outdir) / "_sources" / f"{pagename}.ipynb"
        target.parent.mkdir(parents=True, exist_ok=True)
        nbformat.write(executed, target)
        context["ipynb_source"] = f"{pagename}.ipynb"


def mend_references(app, what, name, obj, options, lines) -> None:
    """Let ``[1]_`` in the docstring of a function mean entry 1 of its module's one list of references.

    numpydoc gives each list labels of its own, made from the name of the object that it belongs to; what is still a
    bare number after it has passed is not in a list of the docstring's own. An entry may begin with initials ("P. D.
    Groves"), which are escaped here, since they would open an enumerated list.
    """
    module = name
    while module not in sys.modules:
        module = module.rpartition(".")[0]
    label = "R" + hashlib.sha256(module.encode()).hexdigest()[:12]
    for i, line in enumerate(lines):
        line = re.sub(r"\[(\d+)\]_", rf"[{label}-\1]_", line)
        lines[i] = re.sub(r"^(\s*\.\. \[[^\]]+\] )(?=[A-Z]\.)", r"\1\\", line)


def setup(app) -> dict:
    # what theme and extensions tell the console about themselves; warnings and errors still show
    app.add_js_file(None, body="console.log = () => {};", priority=0)
    app.connect("config-inited", configure)
    app.connect("html-page-context", offer_notebook, priority=100)  # before the theme makes its buttons
    app.connect("autodoc-process-docstring", mend_references, priority=900)  # after numpydoc
    return {"parallel_read_safe": True, "parallel_write_safe": True}
