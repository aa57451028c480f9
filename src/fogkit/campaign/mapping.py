"""One function over many cases, on any executor: results in memory, in the order of the cases."""

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import closing
from queue import Empty, SimpleQueue
from typing import Any

WINDOW = 1000
"""Calls that are with the executor at a time: enough for some hundreds of workers, and no burden on the memory."""


def map_cases(
    function: Callable[..., Any],
    cases: Iterable[dict[str, Any]],
    *,
    executor: Executor | None = None,
    progress: bool | str = False,
) -> list[Any]:
    """Call a function once for each case and return the results in the order of the cases.

    Parameters
    ----------
    function : callable
        What to run. For a process pool it has to be importable, not a lambda.
    cases : iterable of dict
        Keyword arguments of each call.
    executor : concurrent.futures.Executor, optional
        Where the calls run. None makes a process pool for the time of the call. A thread pool is lighter and as fast
        where the work is done in compiled loops, as in `fogkit.optics.simulate`, which release the interpreter's lock.
    progress : bool or str, optional
        Whether to show a progress bar, or its label.

    Returns
    -------
    list
        Results, the same on any executor with any number of workers.

    Raises
    ------
    TypeError
        If a case is no mapping.
    Exception
        What a call raised; calls not yet begun are cancelled.

    See Also
    --------
    fogkit.campaign.runs.run_campaign : the same with results on the disk, for work that takes hours.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as pool:
    ...     map_cases(round, [dict(number=2.34567, ndigits=n) for n in (1, 3)], executor=pool)
    [2.3, 2.346]
    """
    if executor is None:
        with process_pool() as pool:
            return map_cases(function, cases, executor=pool, progress=progress)
    cases = list(cases)
    for i, case in enumerate(cases):
        if not isinstance(case, Mapping):
            raise TypeError(f"`cases` must hold mappings of argument names to values, got {case!r} as case {i + 1}")
    results = [None] * len(cases)
    calls = ((i, (function,), case) for i, case in enumerate(cases))
    with closing(completed(executor, calls)) as finished, bar(progress, len(cases)) as shown:
        for i, future in finished:
            results[i] = future.result()
            shown.update()
    return results


def completed(
    executor: Executor,
    calls: Iterable[tuple[Any, tuple, Mapping[str, Any]]],
    *,
    window: int = WINDOW,
    tick: float | None = None,
) -> Iterator[tuple[Any, Future] | None]:
    """Futures of calls as they complete, each with its label; no more than a window of them is ever submitted.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Where the calls run.
    calls : iterable of (label, arguments, keyword arguments)
        The first of the arguments is the function. Drawn one by one, when there is room in the window.
    window : int, optional
        Most calls that are submitted and not yet completed.
    tick : float, optional
        Longest silence, s: None is given when nothing has completed for so long.

    Yields
    ------
    (label, Future) or None
        When the iterator is closed, calls that have not begun are cancelled.
    """
    calls, done, pending = iter(calls), SimpleQueue(), {}
    try:
        while True:
            while len(pending) < window and (call := next(calls, None)) is not None:
                label, arguments, keywords = call
                future = executor.submit(*arguments, **keywords)
                pending[future] = label
                future.add_done_callback(done.put)
            if not pending:
                return
            try:
                future = done.get(timeout=tick)
            except Empty:
                yield None
            else:
                yield pending.pop(future), future
    finally:
        for future in pending:
            future.cancel()


def process_pool() -> ProcessPoolExecutor:
    """Processes, one for each processor, that end when this one is killed; by themselves they would wait forever."""
    return ProcessPoolExecutor(initializer=_end_with_parent)


def _end_with_parent() -> None:
    """In a worker: watch the process that made it."""

    def watch() -> None:
        multiprocessing.parent_process().join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def bar(progress: bool | str, total: int, initial: int = 0):
    """Progress bar over `total` calls of which `initial` are done, or one that shows nothing."""
    from tqdm import tqdm

    label = progress if isinstance(progress, str) else None
    return tqdm(total=total, initial=initial, desc=label, disable=not progress)
