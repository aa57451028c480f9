"""Whether a row carries its status: the computed value against the print and against the correction."""

import importlib
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from fogkit.claims.ledger import COLUMNS, Claim, load, papers
from fogkit.claims.printed import Printed

if TYPE_CHECKING:
    import pandas as pd

_MAY_LACK_VALUE = ("undetermined", "definition")


@dataclass(frozen=True, kw_only=True)
class Proof:
    """The outcome of checking a statement that is not a number.

    Attributes
    ----------
    printed : bool
        Whether the statement holds as printed.
    corrected : bool, optional
        Whether the row's correction holds; None if the row has none.
    """

    printed: bool
    corrected: bool | None = None

    def __str__(self) -> str:
        words = {True: "holds", False: "fails"}
        text = f"print {words[self.printed]}"
        return text if self.corrected is None else f"{text}, correction {words[self.corrected]}"


Computed = float | Proof
"""What a row's computation ends in: a number in the printed unit, or a proof."""

Values = Mapping[str, Callable[[], Any] | Any]
"""What a reproduction provides: row id to a value, or to a callable without arguments that computes it when asked."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """A row after recomputation: its value, and why it does not carry its status (None if it does)."""

    claim: Claim
    computed: Computed | None
    problem: str | None


def verify(claim: Claim, computed: Any) -> str | None:
    """Reason why a row does not carry its status, or None if it does.

    Parameters
    ----------
    claim : Claim
        The row.
    computed : float, bool, Proof or None
        What was computed for it, in the printed unit; None if nothing was. The rules are in `fogkit.claims`.

    Returns
    -------
    str or None
        One sentence with the numbers in it.
    """
    for path in claim.code_paths:
        if not _exists(path):
            return f"the note names `{path}`, which does not exist"
    if computed is None:
        return None if claim.status in _MAY_LACK_VALUE else "nothing computes it"
    try:
        computed = _normalise(claim, computed)
    except (TypeError, ValueError) as fault:
        return str(fault)
    if claim.status == "undetermined":
        return None
    proof = computed if isinstance(computed, Proof) else _compare(claim, computed)
    return _against_status(claim, computed, proof)


def _against_status(claim: Claim, computed: Computed, proof: Proof) -> str | None:
    """Reason why the two answers of `proof` do not make the status."""
    shown = f"computed: {computed}" if isinstance(computed, Proof) else f"computed {computed:.6g} {claim.unit}"
    if claim.status in ("reproduced", "definition") and not proof.printed:
        return f"{claim.status}, but the print does not hold: {shown}{_needed(claim, claim.printed)}"
    if claim.status in ("corrected", "refuted"):
        if proof.printed:
            return f"{claim.status}, but the print holds: {shown}{_needed(claim, claim.printed)}"
        if claim.corrected and proof.corrected is None:
            return "the correction was not tested: return Proof(printed=..., corrected=...)"
        if claim.corrected and not proof.corrected:
            return f"{claim.status}, but the correction does not hold: {shown}{_needed(claim, claim.corrected)}"
    return None


def _needed(claim: Claim, text: str) -> str:
    """The end of a reason: what the print allows."""
    if not claim.is_quantity:
        return ""
    reach = Printed.parse(text).reach(claim.tolerance)
    return f" against {text} {claim.unit}" + (f" within {reach:.3g}" if reach else "")


def _normalise(claim: Claim, computed: Any) -> Computed:
    """A proof for a statement, a finite float for a quantity; whatever else came is refused."""
    if hasattr(computed, "item"):  # NumPy scalars and arrays of one element
        computed = computed.item()
    if isinstance(computed, bool):
        computed = Proof(printed=computed)
    if claim.is_quantity:
        if isinstance(computed, Proof) or not isinstance(computed, Real):
            raise TypeError(f"the row has the unit {claim.unit!r}, so a number is needed, got {computed!r}")
        if not math.isfinite(computed):
            raise ValueError(f"the computed value is not finite: {computed}")
        return float(computed)
    if not isinstance(computed, Proof):
        raise TypeError(f"the row has no unit, so a bool or a Proof is needed, got {computed!r}")
    return computed


def _compare(claim: Claim, value: float) -> Proof:
    """The two answers of a proof, from a number."""
    printed = Printed.parse(claim.printed).contains(value, claim.tolerance)
    corrected = Printed.parse(claim.corrected).contains(value, claim.tolerance) if claim.corrected else None
    return Proof(printed=printed, corrected=corrected)


def _exists(path: str) -> bool:
    """Whether a dotted path leads to a module, to what it defines, or to a field of a dataclass."""
    with suppress(AttributeError, ImportError):
        resolve_name(path)
        return True
    owner, _, name = path.rpartition(".")
    with suppress(AttributeError, ImportError):
        return name in resolve_name(owner).__dataclass_fields__
    return False


def recompute(paper: str, *, folder: Path | None = None, values: Values | None = None) -> list[Outcome]:
    """Compute every row of a paper and verify it.

    Parameters
    ----------
    paper : str
        Key of the paper.
    folder : Path, optional
        Another ledger than the package's own.
    values : mapping, optional
        What computes the rows; `fogkit.reproduction.<paper>.values()` if not given.

    Returns
    -------
    list of Outcome
        In the order of the file. An exception raised by a row's computation becomes that row's problem.

    Raises
    ------
    ValueError
        If `values` computes an id that the ledger does not have.
    """
    claims = load(paper, folder=folder)
    if values is None:
        values = importlib.import_module(f"fogkit.reproduction.{paper}").values()
    if unknown := sorted(set(values) - {claim.id for claim in claims}):
        raise ValueError(f"`values` of {paper} computes rows that its ledger does not have: {', '.join(unknown)}")
    return [_outcome(claim, values) for claim in claims]


def _outcome(claim: Claim, values: Values) -> Outcome:
    computed = values.get(claim.id)
    try:
        if callable(computed):
            computed = computed()
    except Exception as fault:  # one broken row must not hide the others; its problem fails the check
        return Outcome(claim=claim, computed=None, problem=f"computing it raised {type(fault).__name__}: {fault}")
    problem = verify(claim, computed)
    try:
        computed = None if computed is None else _normalise(claim, computed)
    except (TypeError, ValueError):
        computed = None  # `problem` says why
    return Outcome(claim=claim, computed=computed, problem=problem)


def evaluate(
    paper: str | None = None, *, folder: Path | None = None, values: Mapping[str, Values] | None = None
) -> "pd.DataFrame":
    """The ledger with the computed values: the columns of the files, then ``computed`` and ``problem``, index `id`.

    Parameters
    ----------
    paper : str, optional
        Key of the paper; all papers if not given.
    folder : Path, optional
        Another ledger than the package's own.
    values : mapping, optional
        Paper key to what computes its rows; `fogkit.reproduction` if not given.

    Returns
    -------
    pandas.DataFrame
        ``computed`` holds a float, a `Proof` or None; ``problem`` is empty text where the row carries its status.
    """
    import pandas as pd

    rows = [
        [*(getattr(outcome.claim, name) for name in COLUMNS), outcome.computed, outcome.problem or ""]
        for key in ([paper] if paper else papers(folder))
        for outcome in recompute(key, folder=folder, values=None if values is None else values[key])
    ]
    frame = pd.DataFrame(rows, columns=[*COLUMNS, "computed", "problem"], dtype=object)
    return frame.set_index("id")


def computed_text(computed: Computed | None) -> str:
    """A computed value for a page or a file: six significant digits, or the proof in words."""
    if computed is None:
        return ""
    return f"{computed:.6g}" if isinstance(computed, float) else str(computed)
