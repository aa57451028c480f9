"""Every status can fail: a row that does not carry its status is caught, and the reason says why."""

import math
import re

import numpy as np
import pytest

from fogkit import claims
from fogkit.claims import Claim, Proof


def claim(status, printed="", unit="", corrected="", tolerance="", note=""):
    return Claim(
        id="fake-row",
        paper="fake",
        where="here",
        quantity="what",
        printed=printed,
        unit=unit,
        status=status,
        corrected=corrected,
        tolerance=tolerance,
        note=note,
    )


NUMBER = claim("reproduced", "0,214", "deg/h")
WIDE = claim("reproduced", "0,214", "deg/h", tolerance="1%", note="why")
SLIP = claim("corrected", "0,214", "deg/h", corrected="0,241")
REFUTED = claim("refuted", "<0,1", "%")
REFUTED_TO = claim("refuted", "<0,1", "%", corrected="0.36")
LOST = claim("undetermined", "0,214", "deg/h", note="no wavelength")
INPUT = claim("definition", "1000", "m", note="`fogkit.claims.Printed`")
PROVED = claim("reproduced", "$a = b$")
SIGN = claim("corrected", "$a = -b$", corrected="$a = b$")
WORDS = claim("refuted", "never")
WORDS_TO = claim("refuted", "never", corrected="sometimes")
OPEN = claim("undetermined", "they coincide", note="lost picture")


@pytest.mark.parametrize(
    ("row", "computed"),
    [
        (NUMBER, 0.2144),
        (NUMBER, np.float64(0.2136)),
        (NUMBER, np.array(0.2136)),
        (WIDE, 0.2124),
        (SLIP, 0.2412),
        (REFUTED, 0.36),
        (REFUTED_TO, 0.364),
        (LOST, None),
        (LOST, 0.2124),
        (LOST, 0.214),
        (INPUT, None),
        (INPUT, 1000),
        (PROVED, True),
        (PROVED, np.bool_(True)),
        (PROVED, Proof(printed=True)),
        (SIGN, Proof(printed=False, corrected=True)),
        (WORDS, False),
        (WORDS_TO, Proof(printed=False, corrected=True)),
        (OPEN, None),
        (OPEN, False),
        (claim("definition", note="`fogkit.claims.ledger.Claim.printed`, a field"), None),
        (claim("definition", note="`fogkit.claims.ledger`, a module"), True),
    ],
)
def test_row_carries_its_status(row, computed):
    assert claims.verify(row, computed) is None


@pytest.mark.parametrize(
    ("row", "computed", "reason"),
    [
        (NUMBER, 0.2124, r"reproduced, but the print does not hold: computed 0\.2124 deg/h against 0,214 deg/h within"),
        (NUMBER, -0.214, "the print does not hold"),
        (NUMBER, None, "nothing computes it"),
        (NUMBER, math.nan, "not finite"),
        (NUMBER, True, "a number is needed, got Proof"),
        (NUMBER, "0.214", "a number is needed"),
        (NUMBER, [0.214], "a number is needed"),
        (WIDE, 0.20, "the print does not hold"),
        (SLIP, 0.214, "corrected, but the print holds"),
        (SLIP, 0.25, r"corrected, but the correction does not hold: .* against 0,241"),
        (SLIP, None, "nothing computes it"),
        (REFUTED, 0.05, "refuted, but the print holds"),
        (REFUTED, None, "nothing computes it"),
        (REFUTED_TO, 0.5, "refuted, but the correction does not hold"),
        (LOST, math.inf, "not finite"),
        (INPUT, 999, "definition, but the print does not hold"),
        (PROVED, False, "reproduced, but the print does not hold: computed: print fails"),
        (PROVED, None, "nothing computes it"),
        (PROVED, 1.0, "a bool or a Proof is needed, got 1.0"),
        (SIGN, Proof(printed=True, corrected=True), "corrected, but the print holds"),
        (SIGN, Proof(printed=False, corrected=False), "the correction does not hold"),
        (SIGN, False, "the correction was not tested"),
        (WORDS, True, "refuted, but the print holds"),
        (WORDS_TO, False, "the correction was not tested"),
        (WORDS_TO, Proof(printed=False, corrected=False), "the correction does not hold"),
        (OPEN, 3.0, "a bool or a Proof is needed"),
        (
            claim("definition", note="`fogkit.no_such_module.f`"),
            None,
            "`fogkit.no_such_module.f`, which does not exist",
        ),
        (claim("definition", note="`fogkit.claims.ledger.no_such`"), None, "which does not exist"),
        (claim("definition", note="`fogkit.claims.ledger.Claim.no_such`"), None, "which does not exist"),
        (claim("reproduced", note="uses `fogkit.claims.gone`"), True, "which does not exist"),
    ],
)
def test_row_that_does_not_carry_its_status(row, computed, reason):
    assert re.search(reason, claims.verify(row, computed) or "carries its status")


def test_recompute_calls_what_it_needs(write, rows, values):
    outcomes = claims.recompute("fake", folder=write(rows), values=values)
    assert [outcome.problem for outcome in outcomes] == [None] * len(rows)
    assert [outcome.computed for outcome in outcomes] == [
        math.pi,
        0.2,
        2.512,
        Proof(printed=False, corrected=True),
        7.25,
        None,
    ]


def test_broken_computation_fails_its_row_only(write, rows, values):
    values["fake-bound"] = lambda: 1 / 0
    problems = {o.claim.id: o.problem for o in claims.recompute("fake", folder=write(rows), values=values)}
    assert "ZeroDivisionError: division by zero" in problems.pop("fake-bound")
    assert set(problems.values()) == {None}


def test_value_without_a_row(write, rows, values):
    values["fake-gone"] = 1.0
    with pytest.raises(ValueError, match="does not have: fake-gone"):
        claims.recompute("fake", folder=write(rows), values=values)


def test_evaluate_adds_what_was_computed(write, rows, values):
    values["fake-lost"] = "unreadable"
    table = claims.evaluate(folder=write(rows), values={"fake": values})
    assert table.loc["fake-number", "computed"] == math.pi
    assert table.loc["fake-sign", "computed"] == Proof(printed=False, corrected=True)
    assert table.loc["fake-lost", "computed"] is None
    assert "a number is needed" in table.loc["fake-lost", "problem"]
    assert (table["problem"] == "").sum() == len(rows) - 1
