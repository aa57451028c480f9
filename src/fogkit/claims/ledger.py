"""The rows of the ledger: one CSV file per paper, read and checked."""

import csv
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from fogkit.claims.printed import Printed

if TYPE_CHECKING:
    import pandas as pd

STATUSES = ("reproduced", "corrected", "refuted", "undetermined", "definition")
"""What can become of a statement, in the order of the counts."""

_CODE_PATH = re.compile(r"\bfogkit(?:\.[A-Za-z_]\w*)+")


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One statement of a paper and its status; the columns are described in `fogkit.claims`.

    Raises
    ------
    ValueError
        If the fields do not form a row: unknown status, missing correction, a number that does not parse, ...
    """

    id: str
    paper: str
    where: str
    quantity: str
    printed: str
    unit: str
    status: str
    corrected: str
    tolerance: str
    note: str

    def __post_init__(self) -> None:
        if problem := next(_problems(self), None):
            raise ValueError(problem)

    @property
    def is_quantity(self) -> bool:
        """Whether the row needs a number; the others are statements and need a `fogkit.claims.Proof`."""
        return bool(self.unit)

    @property
    def code_paths(self) -> list[str]:
        """The dotted ``fogkit....`` names in the note."""
        return _CODE_PATH.findall(self.note)


COLUMNS = tuple(field.name for field in fields(Claim))
"""The columns of ``data/claims/<paper>.csv``, in order."""


def _problems(claim: Claim) -> Iterable[str]:
    """What is wrong with a row, first things first."""
    if not re.fullmatch(r"[a-z0-9]+(?:[-.][a-z0-9]+)+", claim.id):
        yield f"`id` must be lower-case words, digits and single hyphens, got {claim.id!r}"
    if not claim.id.startswith(f"{claim.paper}-"):
        yield f"`id` must start with the paper's key {claim.paper!r} and a hyphen, got {claim.id!r}"
    if claim.status not in STATUSES:
        yield f"`status` must be one of {', '.join(STATUSES)}, got {claim.status!r}"
    for name in ("where", "quantity"):
        if not getattr(claim, name):
            yield f"`{name}` is empty"
    yield from _problems_with_correction(claim)
    yield from _problems_with_numbers(claim)
    if claim.status == "undetermined" and not claim.note:
        yield "`note` must name the input that the paper does not give: the status is undetermined"
    if claim.status == "definition" and not claim.code_paths:
        yield "`note` must name what implements the definition, as a dotted path `fogkit....`"


def _problems_with_correction(claim: Claim) -> Iterable[str]:
    if claim.status == "corrected" and not claim.corrected:
        yield "`corrected` is empty, but the status is corrected"
    if claim.status not in ("corrected", "refuted") and claim.corrected:
        yield f"`corrected` must be empty for the status {claim.status}, got {claim.corrected!r}"
    if claim.corrected and claim.corrected == claim.printed:
        yield "`corrected` repeats `printed`"


def _problems_with_numbers(claim: Claim) -> Iterable[str]:
    if claim.is_quantity:
        for name, text in (("printed", claim.printed), ("corrected", claim.corrected)):
            if text and not _is_number(text):
                yield f"`{name}` of a row with a unit must be a number, a bound (<x) or a range (a..b), got {text!r}"
        if not claim.printed and claim.status != "undetermined":
            yield "`printed` is empty; only an undetermined quantity may lack it (a lost figure or table)"
    elif claim.printed and _is_number(claim.printed):
        yield f"`unit` is empty, but `printed` is the number {claim.printed!r}: give the unit, `1` for a pure number"
    if claim.tolerance:
        if not (claim.is_quantity and claim.printed):
            yield "`tolerance` has nothing to apply to: the row has no printed number"
        if not _is_tolerance(claim.tolerance):
            yield f"`tolerance` must be a non-negative number or percentage such as 0.01 or 5%, got {claim.tolerance!r}"
        if not claim.note:
            yield "`note` must give the reason for the `tolerance`"


def _is_number(text: str) -> bool:
    try:
        Printed.parse(text)
    except ValueError:
        return False
    return True


def _is_tolerance(text: str) -> bool:
    try:
        return 0 <= float(text.removesuffix("%")) < math.inf
    except ValueError:
        return False


def claims_folder() -> Path:
    """Folder of the ledger's CSV files: inside an installed wheel, else in the repository that this file belongs to.

    Raises
    ------
    FileNotFoundError
        If there is neither.
    """
    here = Path(__file__).resolve()
    candidates = (here.parents[1] / "_data" / "claims", here.parents[3] / "data" / "claims")
    for folder in candidates:
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the ledger's folder is missing; looked for {' and '.join(map(str, candidates))}")


def papers(folder: Path | None = None) -> list[str]:
    """Keys of the papers that have a ledger, sorted."""
    return sorted(path.stem for path in (folder or claims_folder()).glob("*.csv"))


def load(paper: str | None = None, *, folder: Path | None = None) -> list[Claim]:
    """The rows of one paper, or of all papers, in the order of the files.

    Parameters
    ----------
    paper : str, optional
        Key of the paper; all papers if not given.
    folder : Path, optional
        Another ledger than the package's own.

    Raises
    ------
    ValueError
        If `paper` has no ledger, or a file is malformed: the message names the file and every line at fault.
    """
    folder = folder or claims_folder()
    known = papers(folder)
    if paper is not None and paper not in known:
        raise ValueError(f"`paper` must be one of {', '.join(known) or '(the ledger is empty)'}, got {paper!r}")
    return [claim for key in ([paper] if paper else known) for claim in _read(folder / f"{key}.csv")]


def _read(path: Path) -> list[Claim]:
    """The rows of one file; one ``ValueError`` for all that is wrong with it."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file, strict=True)
        header = next(reader, [])
        if header != list(COLUMNS):
            raise ValueError(f"{path}:1: the columns must be {','.join(COLUMNS)}; {_difference(header)}")
        numbered = [(reader.line_num, cells) for cells in reader if cells]
    claims, faults, lines = [], [], {}
    for line, cells in numbered:
        try:
            claim = _row(cells, path.stem)
            if claim.id in lines:
                raise ValueError(f"`id` {claim.id!r} is already on line {lines[claim.id]}")
        except ValueError as fault:
            faults.append(f"{path}:{line}: {fault}")
        else:
            lines[claim.id] = line
            claims.append(claim)
    if faults:
        raise ValueError("\n".join(faults))
    return claims


def _row(cells: list[str], key: str) -> Claim:
    if len(cells) != len(COLUMNS):
        raise ValueError(f"{len(COLUMNS)} cells are needed, got {len(cells)}: quote a cell that contains a comma")
    claim = Claim(**dict(zip(COLUMNS, map(str.strip, cells), strict=True)))
    if claim.paper != key:
        raise ValueError(f"`paper` must be the name of the file, {key!r}, got {claim.paper!r}")
    return claim


def _difference(header: list[str]) -> str:
    missing = [name for name in COLUMNS if name not in header]
    unknown = [name for name in header if name not in COLUMNS]
    if not missing and not unknown:
        return f"they are in another order: {','.join(header)}"
    found = (("missing", missing), ("unknown", unknown))
    return "; ".join(f"{kind}: {', '.join(names)}" for kind, names in found if names)


def table(paper: str | None = None, *, folder: Path | None = None) -> "pd.DataFrame":
    """The ledger as a table of text, one row per claim, index `id`."""
    import pandas as pd

    rows = [[getattr(claim, name) for name in COLUMNS] for claim in load(paper, folder=folder)]
    return pd.DataFrame(rows, columns=list(COLUMNS)).set_index("id")


def counts(paper: str | None = None, *, folder: Path | None = None) -> dict[str, dict[str, int]]:
    """Number of rows of each status, per paper: ``{paper: {status: n, ..., "total": n}}``, last the sum ``all papers``.

    The sum is left out when there is only one paper.
    """
    result: dict[str, dict[str, int]] = {}
    for claim in load(paper, folder=folder):
        for key in (claim.paper, "all papers"):
            row = result.setdefault(key, dict.fromkeys((*STATUSES, "total"), 0))
            row[claim.status] += 1
            row["total"] += 1
    total = result.pop("all papers", None)
    return {**result, "all papers": total} if total and len(result) > 1 else result
