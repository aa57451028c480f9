"""A ledger of one invented paper: a row of every status, and what computes them."""

import csv
import math

import pytest

from fogkit.claims import COLUMNS, Proof

ROWS = [
    {
        "id": "fake-number",
        "where": "eq. (1)",
        "quantity": "Ratio of a circle",
        "printed": "3,14",
        "unit": "1",
        "status": "reproduced",
    },
    {
        "id": "fake-bound",
        "where": "text",
        "quantity": "Difference",
        "printed": "<0.1",
        "unit": "%",
        "status": "refuted",
        "note": "It is 0.2 %.",
    },
    {
        "id": "fake-slip",
        "where": "Table 1",
        "quantity": "Drift",
        "printed": "2,15",
        "unit": "deg/h",
        "status": "corrected",
        "corrected": "2.51",
        "note": "Digits swapped, a | b.",
    },
    {
        "id": "fake-sign",
        "where": "eq. (2)",
        "quantity": "Sign of <x>",
        "printed": "$y = -x$",
        "status": "corrected",
        "corrected": "$y = +x$",
        "note": "By `sympy`.",
    },
    {
        "id": "fake-lost",
        "where": "Fig. 1",
        "quantity": "Peak",
        "unit": "deg/h",
        "status": "undetermined",
        "note": "Lost picture.",
    },
    {
        "id": "fake-convention",
        "where": "text",
        "quantity": "Reading a print",
        "status": "definition",
        "note": "`fogkit.claims.printed.Printed.parse`.",
    },
]


@pytest.fixture
def rows():
    """The rows as dictionaries, to be changed by a test before `write` stores them."""
    return [{**dict.fromkeys(COLUMNS, ""), "paper": "fake", **row} for row in ROWS]


@pytest.fixture
def write(tmp_path):
    """Function that stores rows as ``<paper>.csv`` and returns the folder."""

    def store(rows, paper="fake"):
        with (tmp_path / f"{paper}.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
        return tmp_path

    return store


@pytest.fixture
def values():
    """What computes the invented paper's rows."""
    return {
        "fake-number": lambda: math.pi,
        "fake-bound": lambda: 0.2,
        "fake-slip": lambda: 2.512,
        "fake-sign": lambda: Proof(printed=False, corrected=True),
        "fake-lost": 7.25,
    }
