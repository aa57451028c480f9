"""Chapters are executed several at a time, while Sphinx reads the pages that have no cells.

MyST-NB executes a chapter when its page is read, one after another. Here those that its cache does not hold are started
before the first page is read, as many at a time as there are processors, the longest first. Each page then waits for
its own chapter and puts it into the cache, where MyST-NB finds it; only this one process writes there. A chapter that
fails is not kept: MyST-NB executes it again, and reports the failure with page and traceback as it always does.
"""

import os
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from sphinx.util import logging

logger = logging.getLogger(__name__)


def stale_notebooks(paths: dict[str, Path], myst_config, nb_config, cache) -> dict:
    """Notebooks, by name, of the pages with cells whose outputs the cache does not hold."""
    from myst_nb.core.read import create_nb_reader

    stale = {}
    for name, path in paths.items():
        text = path.read_text(encoding="utf-8")
        reader = create_nb_reader(str(path), myst_config, nb_config, text) if path.suffix == ".md" else None
        if reader is None:
            continue
        notebook = reader.read(text)
        try:
            cache.match_cache_notebook(notebook)
        except KeyError:
            stale[name] = notebook
    return stale


def seconds_before(caches: Path) -> dict[str, float]:
    """How long each notebook took when it was last executed, by its path, as the caches of older sources tell."""
    from jupyter_cache import get_cache

    seconds = {}
    for cache in sorted((p.parent for p in caches.glob("*/global.db")), key=lambda p: p.stat().st_mtime):
        for record in get_cache(cache).list_cache_records():
            seconds[record.uri] = record.data.get("execution_seconds", 0.0)
    return seconds


def amount_of_code(notebook) -> int:
    return sum(len(cell.source) for cell in notebook.cells if cell.cell_type == "code")


class Executions:
    """The executions of one build. Threads do: the work is done by the kernels, each a process of its own."""

    def __init__(self, cache, timeout: int, workers: int):
        self._cache, self._timeout = cache, timeout
        self._pool = ThreadPoolExecutor(workers)
        self._running: dict[str, tuple[Path, Future]] = {}

    def start(self, name: str, path: Path, notebook) -> None:
        from jupyter_cache.executors.utils import single_nb_execution

        result = self._pool.submit(
            single_nb_execution, notebook, cwd=str(path.parent), timeout=self._timeout, allow_errors=False
        )
        self._running[name] = path, result

    def finish(self, name: str) -> None:
        """Wait for a chapter, if it was started, and keep its outputs unless it failed."""
        from jupyter_cache.base import CacheBundleIn

        if name not in self._running:
            return
        path, result = self._running.pop(name)
        executed = result.result()
        if executed.err is None:  # output on stderr is found in the cache, too, and is an error of its page
            bundle = CacheBundleIn(executed.nb, str(path), data={"execution_seconds": executed.time})
            self._cache.cache_notebook_bundle(bundle, check_validity=False, overwrite=True)
            logger.info("%s: executed in %.1f s", name, executed.time)

    def cancel(self) -> None:
        """Start nothing more; what runs comes to its end."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def start(app, env, docnames) -> None:
    import matplotlib.font_manager  # noqa: F401 - makes its list of fonts once, before several kernels would
    from jupyter_cache import get_cache

    if env.mystnb_config.execution_mode != "cache":
        return
    folder = Path(app.config.nb_execution_cache_path)
    cache = get_cache(folder)
    paths = {name: Path(env.doc2path(name)) for name in docnames}
    notebooks = stale_notebooks(paths, env.myst_config, env.mystnb_config, cache)
    before = seconds_before(folder.parent)

    def work(name: str) -> tuple[float, int]:
        return before.get(str(paths[name]), 0.0), amount_of_code(notebooks[name])

    app.fogkit_executions = Executions(cache, env.mystnb_config.execution_timeout, os.cpu_count() or 1)
    for name in sorted(notebooks, key=work, reverse=True):
        app.fogkit_executions.start(name, paths[name], notebooks[name])


def finish(app, docname, source) -> None:
    if hasattr(app, "fogkit_executions"):
        app.fogkit_executions.finish(docname)


def end(app, exception) -> None:
    if hasattr(app, "fogkit_executions"):
        app.fogkit_executions.cancel()


def setup(app) -> dict:
    app.connect("env-before-read-docs", start)
    app.connect("source-read", finish)
    app.connect("build-finished", end)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
