"""``python -m fogkit.claims``: counts of the ledger, rows with computed values, check of every status."""

import argparse
import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from fogkit.claims.ledger import COLUMNS, counts, papers
from fogkit.claims.verdict import Outcome, Values, computed_text, recompute


def main(
    arguments: Sequence[str] | None = None, *, folder: Path | None = None, values: Mapping[str, Values] | None = None
) -> int:
    """Run the command; the exit code is 1 if ``--check`` finds a row that does not carry its status, else 0.

    Parameters
    ----------
    arguments : sequence of str, optional
        The command line; `sys.argv` if not given.
    folder, values : optional
        Another ledger, and what computes its papers' rows; the package's own if not given.
    """
    options = _parser().parse_args(arguments)
    if options.paper is not None and options.paper not in papers(folder):
        _parser().error(f"--paper must be one of {', '.join(papers(folder))}, got {options.paper!r}")
    print(counts_text(options.paper, folder=folder))
    if not (options.csv or options.check):
        return 0
    outcomes = [
        outcome
        for key in ([options.paper] if options.paper else papers(folder))
        for outcome in recompute(key, folder=folder, values=None if values is None else values[key])
    ]
    failed = [outcome for outcome in outcomes if outcome.problem]
    if options.csv:
        try:
            write_csv(options.csv, outcomes)
        except OSError as fault:
            print(f"`--csv` must be a file that can be written: {fault}", file=sys.stderr)
            return 2
        print(f"\n{len(outcomes)} rows written to {options.csv}")
    if options.check:
        for outcome in failed:
            print(f"{outcome.claim.id}: {outcome.problem}", file=sys.stderr)
        print(f"\n{len(outcomes) - len(failed)} of {len(outcomes)} rows carry their status")
    elif failed:
        print(f"{len(failed)} rows do not carry their status: --check lists them", file=sys.stderr)
    return 1 if failed else 0


def _parser() -> argparse.ArgumentParser:
    about = "The ledger of claims: counts per paper and status."
    parser = argparse.ArgumentParser(prog="python -m fogkit.claims", description=about)
    parser.add_argument("--paper", metavar="KEY", help="only this paper")
    parser.add_argument("--csv", metavar="PATH", type=Path, help="write all rows with the computed value")
    parser.add_argument("--check", action="store_true", help="exit 1 and list the rows that do not carry their status")
    return parser


def counts_text(paper: str | None = None, *, folder: Path | None = None) -> str:
    """The counts as aligned text."""
    rows = counts(paper, folder=folder)
    if not rows:
        return "the ledger is empty"
    head = ["paper", *next(iter(rows.values()))]
    body = [[key, *map(str, row.values())] for key, row in rows.items()]
    first, *others = (max(map(len, column)) for column in zip(head, *body, strict=True))
    lines = [
        [key.ljust(first), *(cell.rjust(width) for cell, width in zip(cells, others, strict=True))]
        for key, *cells in (head, *body)
    ]
    return "\n".join(map("  ".join, lines))


def write_csv(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the rows as they stand in the ledger, with a last column ``computed``."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COLUMNS, "computed"])
        for outcome in outcomes:
            writer.writerow([*(getattr(outcome.claim, name) for name in COLUMNS), computed_text(outcome.computed)])


if __name__ == "__main__":
    sys.exit(main())
