"""Campaigns that outlive a crash: each run seeded by its own case, stored as it ends, kept when it fails."""

import json
import os
import platform
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fogkit import __version__, checks
from fogkit.campaign import store
from fogkit.campaign.attempts import attempt, failure
from fogkit.campaign.cases import brief, places_of, rows, stored_inputs
from fogkit.campaign.identity import encoded, importable_name, seed_text, source_digest
from fogkit.campaign.mapping import WINDOW, bar, completed, process_pool
from fogkit.campaign.store import CampaignMismatchError

if TYPE_CHECKING:
    from pandas import DataFrame

MOST_WAITING = 10_000
"""Results that are kept in memory at most before they are written."""


def run_campaign(
    function: Callable[..., Any],
    cases: "DataFrame | Iterable[Mapping[str, Any]]",
    folder: str | os.PathLike,
    *,
    common: Mapping[str, Any] | None = None,
    seed: int | None = None,
    repeats: int = 1,
    executor: Executor | None = None,
    retries: int = 0,
    again: bool = False,
    interval: float = 10.0,
    window: int = WINDOW,
    progress: bool | str = True,
) -> "DataFrame":
    """Run a function over many cases, store each result as it comes, and go on where an earlier call was stopped.

    Parameters
    ----------
    function : callable
        What to run: a function that can be imported by its name. It returns a number, a text, an array, a mapping or a
        dataclass of such; each entry of the last two becomes a column.
    cases : DataFrame or iterable of mappings
        Arguments of each case, of the same names in all. `grid` and `spread` make such tables. Cases may be added when
        the campaign is resumed, at any place; none may be taken away.
    folder : path
        Where the results are stored: that of a campaign which was stopped, to resume it, or a new one.
    common : mapping, optional
        Arguments that are the same in all cases. They go with every call, so name large data rather than pass them.
    seed : int, optional
        Seed of the campaign. With it the function gets an argument `rng`, a generator of its own for each run.
    repeats : int, optional
        Runs of each case, each with its own generator. It may be raised when the campaign is resumed.
    executor : concurrent.futures.Executor, optional
        Where the calls run; None makes a process pool. That of a Dask client is ``client.get_executor()``.
    retries : int, optional
        How often a run that failed is tried again at once, with the same inputs and the same random numbers.
    again : bool, optional
        Whether runs that failed in an earlier call are run again. Otherwise they are kept as they are.
    interval : float, optional
        Longest time that a result waits to be written, s. With 0 each is written as it comes, in a file of its own.
    window : int, optional
        Most runs that are with the executor at a time; some per worker.
    progress : bool or str, optional
        Whether to show a progress bar, or its label.

    Returns
    -------
    DataFrame
        One row for each run in the order of the cases: inputs, outputs (a single value as ``result``; arrays as lists),
        then `repeat`, `seed` (for `case_generator`), `run_time` in s, `attempts`, and for a failure the class of the
        `exception`, its `message` and `traceback`. An input or output that would share the name of another column
        keeps the one it has in the files, such as ``input.seed`` or ``output.message``.

    Raises
    ------
    CampaignMismatchError
        If the folder holds another campaign: another function, seed, common arguments or parameters, or cases that are
        not given now. The message names what differs.
    TypeError
        If the function cannot be imported by name or has no such arguments, or if a value cannot be stored.
    ValueError
        If a case comes twice (for many runs of one case there are `repeats`), or cases have different arguments.
    BrokenExecutor
        If the executor loses its workers. What had come is stored: call again to resume.

    Warns
    -----
    UserWarning
        If runs failed, with their number; or if the campaign was begun with another version of the package or another
        text of the function, so that results of both would stand together.

    Notes
    -----
    A run's stream is that of a ``SeedSequence`` of the campaign's seed whose spawn key is a digest of the case's inputs
    and the number of the repeat. It depends on nothing else: results are the same on any number of workers, after a
    restart, and when cases are added. Whole numbers and equal floats are the same input.

    A run that is stored twice, because two processes worked on one folder, is read once.

    Examples
    --------
    >>> import tempfile
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> cases = [{"number": 2.34567, "ndigits": 1}, {"number": 2.34567, "ndigits": 3}]
    >>> with ThreadPoolExecutor(1) as pool, tempfile.TemporaryDirectory() as folder:
    ...     table = run_campaign(round, cases, folder, executor=pool, progress=False)
    >>> table[["number", "ndigits", "result"]]
        number  ndigits  result
    0  2.34567        1   2.300
    1  2.34567        3   2.346
    """
    name = importable_name("`function`", function)
    common = {} if common is None else dict(checks.instance("common", common, Mapping))
    seed = None if seed is None else checks.integer("seed", seed, minimum=0)
    repeats = checks.integer("repeats", repeats, minimum=1)
    retries = checks.integer("retries", retries, minimum=0)
    interval = checks.non_negative("interval", interval, "s")
    window = checks.integer("window", window, minimum=1)
    cases = cases if hasattr(cases, "columns") else list(cases)
    places = places_of(function, cases, common, seed)
    folder = Path(folder)
    asked = {
        "function": name,
        "source": source_digest(function),
        "parameters": list(next(rows(cases))),
        "common": {key: encoded(f"`common[{key!r}]`", value, full=False) for key, value in common.items()},
        "seed": seed,
        "version": __version__,
        "python": platform.python_version(),
    }
    _require_same(folder, store.describe(folder, asked), asked)
    done = _done(folder, places, repeats, again)
    if len(done) < len(places) * repeats:
        labels = _labels(cases, places, repeats, done, seed)
        calls = ((label, (attempt, function, {**common, **case}, label["seed"], retries), {}) for label, case in labels)
        shown = bar(progress, len(places) * repeats, len(done))
        with process_pool() if executor is None else nullcontext(executor) as pool:
            _collect(folder, completed(pool, calls, window=window, tick=interval or None), interval, shown)
    return _finished(folder, places, repeats, asked["parameters"])


def _require_same(folder: Path, found: Mapping[str, Any], asked: Mapping[str, Any]) -> None:
    """Refuse to mix the results of two campaigns; warn where it cannot be known whether they differ."""
    differences = [
        f"{key} was {found[key]!r} and is {asked[key]!r}" for key in ("function", "seed") if found[key] != asked[key]
    ]
    if sorted(found["parameters"]) != sorted(asked["parameters"]):
        differences.append(f"the parameters were {found['parameters']} and are {asked['parameters']}")
    for key in sorted({*found["common"], *asked["common"]}):
        was, now = (side["common"].get(key, "absent") for side in (found, asked))
        if json.dumps(was, sort_keys=True) != json.dumps(now, sort_keys=True):  # in text NaN is NaN
            differences.append(f"`common` differs in `{key}`: it was {str(was)[:100]} and is {str(now)[:100]}")
    if differences:
        raise CampaignMismatchError(
            f"`folder` {folder} holds another campaign: {'; '.join(differences)}. Give another folder, or the same as "
            "before"
        )
    if found["version"] != asked["version"]:
        warnings.warn(
            f"the campaign in {folder} was begun with fogkit {found['version']} and goes on with {asked['version']}: "
            "its results may come from two different computations",
            stacklevel=3,
        )
    if found["source"] != asked["source"]:
        warnings.warn(
            f"the text of {asked['function']} has changed since the campaign in {folder} was begun: its results may "
            "come from two different computations",
            stacklevel=3,
        )


def _done(folder: Path, places: Mapping[str, int], repeats: int, again: bool) -> set[tuple[str, int]]:
    """Runs that need not be run; refuse if some of those stored are not among what is asked."""
    stored = store.stored(folder)
    foreign = {identity for identity, _ in stored if identity not in places}
    if foreign:
        example = brief(store.inputs_of(folder, min(foreign)))
        raise CampaignMismatchError(
            f"`folder` {folder} holds results of {len(foreign)} cases that are not among `cases`, such as {example}. "
            "Cases may be added to a campaign but not taken away: give these too, or another folder"
        )
    if stored and (most := max(repeat for _, repeat in stored) + 1) > repeats:
        raise CampaignMismatchError(
            f"`folder` {folder} holds up to {most} repeats of a case, more than `repeats` {repeats}"
        )
    return {run for run, success in stored.items() if success or not again}


def _labels(
    cases: "DataFrame | list", places: Mapping[str, int], repeats: int, done: set[tuple[str, int]], seed: int | None
) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """What is stored of each run that is to be run, beside what comes of it; and its arguments."""
    for (identity, place), case in zip(places.items(), rows(cases), strict=True):
        left = [repeat for repeat in range(repeats) if (identity, repeat) not in done]
        for repeat in left:
            stream = None if seed is None else seed_text(seed, identity, repeat)
            label = {"identity": identity, "place": place, "repeat": repeat, "seed": stream}
            yield label | {"input": stored_inputs(case, place)}, case


def _collect(folder: Path, finished: Iterator[tuple[dict[str, Any], Future] | None], interval: float, shown) -> None:
    """Store results as they come, whatever ends it."""
    waiting, written = [], time.monotonic()
    failed = 0
    with shown, closing(finished):
        try:
            for item in finished:
                if item is not None:
                    label, future = item
                    waiting.append(label | _row(future))
                    failed += waiting[-1]["exception"] is not None
                    shown.update()
                    if failed:
                        shown.set_postfix(failed=failed, refresh=False)
                if waiting and (time.monotonic() - written >= interval or len(waiting) >= MOST_WAITING):
                    ready, waiting = waiting, []
                    store.append(folder, ready)
                    written = time.monotonic()
        finally:
            if waiting:
                store.append(folder, waiting)


def _row(future: Future) -> dict[str, Any]:
    """What a worker sent, or why it could not; the loss of the executor itself is no failure of a case."""
    try:
        return future.result()
    except (BrokenExecutor, CancelledError, KeyboardInterrupt):
        raise
    except BaseException as error:
        return failure(error, 1)


def _finished(folder: Path, places: Mapping[str, int], repeats: int, parameters: list[str]) -> "DataFrame":
    """Results of the whole campaign, with a warning if there are failures among them."""
    table = store.gathered(folder)
    result = store.ordered(table, table["identity"].map(places), parameters)
    assert len(result) == len(places) * repeats
    failed = result[result["exception"].notna()]
    if len(failed):
        first = failed.iloc[0]
        warnings.warn(
            f"{len(failed)} of {len(result)} runs failed, the first with {first['exception']}: {first['message']}. "
            "Their rows hold the traceback; `again=True` runs them again",
            stacklevel=3,
        )
    return result
