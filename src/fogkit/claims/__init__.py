"""The ledger of claims: every number, equation, figure and conclusion of the papers, and what became of it.

A paper is one file ``data/claims/<paper>.csv`` and one module ``fogkit.reproduction.<paper>`` whose ``values()`` maps
row ids to what computes them. One row is one statement of the print.

Columns
-------
``id``
    ``<paper>-<name>``: lower case, digits, hyphens. It never changes: chapters, tests and reproductions refer to it.
``paper``
    The key of the paper, which is also the name of the file.
``where``
    Place in the print: equation, section, figure, table.
``quantity``
    What is stated, in our words.
``printed``
    What the print says: for a quantity the number as printed, for a statement a formula or its gist in words. ``$...$``
    is LaTeX.
``unit``
    The printed unit makes the row a *quantity*; ``1`` stands for a pure number. Empty makes the row a *statement*.
``status``
    One of `STATUSES`, below.
``corrected``
    What is right, where the print is wrong; for a quantity a number in the same unit.
``tolerance``
    Replaces the print's own rounding: absolute in the printed unit, or a percentage of the printed value (``0.5%``).
    Its reason belongs in ``note``.
``note``
    Proof, reason, missing input, or the function that implements a definition (a dotted ``fogkit....`` path).

How a print is read (`Printed`)
-------------------------------
``0.214``, ``0,214``, ``12 500``, ``1.5e-3``, ``1,5*10^-3`` stand for every value that rounds to them: half a unit of
the last printed digit to either side. A comma is a decimal comma. ``3/4``, ``pi/2``, ``7pi/8`` are exact. ``<0.1``,
``<=0.1``, ``>5``, ``>=5`` are bounds, taken as they stand. ``3..5`` (also with a dash or ``to``) is a range: a value
inside it agrees.

What is computed
----------------
A quantity needs a number in the row's unit. A statement needs a `Proof`: whether the print holds and, where the row
has a ``corrected``, whether the correction holds. A plain ``bool`` is short for ``Proof(printed=...)``. A number is
turned into the same two answers by comparing it with ``printed`` and ``corrected``; so one rule serves every row
(`verify`):

==================  ================  ====================  ==========================================================
status              the print         the correction        besides
==================  ================  ====================  ==========================================================
``reproduced``      holds             absent
``corrected``       does not hold     holds
``refuted``         does not hold     holds, or is absent
``undetermined``    not judged        absent                the note names the missing input; computing is optional
``definition``      holds, if tested  absent                the note names a ``fogkit`` object that exists
==================  ================  ====================  ==========================================================

``python -m fogkit.claims`` prints the counts; ``--check`` recomputes every row and fails on one that does not carry its
status.
"""

from fogkit.claims.ledger import COLUMNS, STATUSES, Claim, claims_folder, counts, load, papers, table
from fogkit.claims.pages import counts_markdown, errata_markdown, ledger_html
from fogkit.claims.printed import Printed
from fogkit.claims.verdict import Outcome, Proof, evaluate, recompute, verify

__all__ = [
    "COLUMNS",
    "STATUSES",
    "Claim",
    "Outcome",
    "Printed",
    "Proof",
    "claims_folder",
    "counts",
    "counts_markdown",
    "errata_markdown",
    "evaluate",
    "ledger_html",
    "load",
    "papers",
    "recompute",
    "table",
    "verify",
]
