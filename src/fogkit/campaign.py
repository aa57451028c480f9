"""Many runs of anything: one function over many cases, on any executor, with a progress bar."""

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Any


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

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as pool:
    ...     map_cases(round, [dict(number=2.34567, ndigits=n) for n in (1, 3)], executor=pool)
    [2.3, 2.346]
    """
    if executor is None:
        with ProcessPoolExecutor() as pool:
            return map_cases(function, cases, executor=pool, progress=progress)
    cases = list(cases)
    for i, case in enumerate(cases):
        if not isinstance(case, Mapping):
            raise TypeError(f"`cases` must hold mappings of argument names to values, got {case!r} as case {i + 1}")
    futures = [executor.submit(function, **case) for case in cases]
    try:
        return [future.result() for future in _bar(futures, progress)]
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _bar(items: list, progress: bool | str) -> Iterable:
    """The items behind a progress bar, if one is wanted."""
    if not progress:
        return items
    from tqdm import tqdm

    return tqdm(items, desc=progress if isinstance(progress, str) else None)
