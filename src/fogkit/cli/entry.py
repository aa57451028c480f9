"""From the command line to the exit code."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from fogkit.cli.arguments import UsageError, parser

if TYPE_CHECKING:
    from fogkit.cli.results import Result

DONE, BAD_DATA, BAD_USAGE, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if not given.

    Returns
    -------
    int
        0 done, 1 bad data, 2 bad usage, 130 interrupted. What is wrong stands on the standard error in one sentence.
    """
    try:
        args = parser().parse_args(argv)
    except SystemExit as stop:  # argparse has said why
        return stop.code if isinstance(stop.code, int) else BAD_USAGE
    try:
        return _run(args)
    except KeyboardInterrupt:
        _say("fogkit: interrupted; nothing half-written is left")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has gone: `fogkit ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _run(args: Namespace) -> int:
    """Run one command; errors of the data become a sentence."""
    try:
        result = _called(_function(args.run), args)
        _write(args, result)
    except UsageError as error:
        _say(f"fogkit: {error}")
        return BAD_USAGE
    except Exception as error:
        if args.debug:
            raise
        _say(f"fogkit: {_sentence(error)}")
        return BAD_DATA
    if not args.quiet:
        from fogkit.cli.summaries import summary

        print(summary(result), flush=True)
    bad = [f for f in result.findings if f.severity == "bad"]
    if bad:
        more = f", and {len(bad) - 1} more" * (len(bad) > 1)
        channel = f" of {bad[0].channel}" * bool(bad[0].channel)
        _say(f"fogkit: {bad[0].check}{channel}: {bad[0].text}{more}")
    return BAD_DATA if bad else DONE


def _function(name: str) -> Callable[[Namespace], "Result"]:
    module, _, function = name.partition(":")
    return getattr(import_module(f"fogkit.cli.{module}"), function)


def _called(function: Callable[[Namespace], "Result"], args: Namespace) -> "Result":
    """Result of a command, its warnings among the findings."""
    import warnings
    from dataclasses import replace

    from fogkit.io.errors import first_sentence
    from fogkit.io.verdicts import Finding

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", UserWarning)
        result = function(args)
    texts = list(dict.fromkeys(first_sentence(w.message, 400) for w in caught if issubclass(w.category, UserWarning)))
    found = [Finding(check="warning", severity="doubtful", text=text) for text in texts]
    return replace(result, findings=[*result.findings, *found])


def _write(args: Namespace, result: "Result") -> None:
    """The result as JSON and as a report, where they are asked for."""
    from pathlib import Path

    from fogkit.cli.files import write_whole

    if args.output:
        write_whole(Path(args.output), result.to_json())
    if args.report:
        from fogkit.cli.report import page

        write_whole(Path(args.report), page(result))


def _sentence(error: Exception) -> str:
    """One line: what is wrong with the data, or with the program."""
    from fogkit.io.errors import first_sentence

    text = first_sentence(error, 500)
    if isinstance(error, MemoryError):
        return "the recording does not fit into memory"
    if isinstance(error, ValueError | TypeError | RuntimeError | OSError):
        return text
    return f"this is an error of fogkit, {type(error).__name__}: {text}; --debug shows where it arose"


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
