"""Every row of the package's own ledger is recomputed and carries its status."""

from functools import cache

import pytest

from fogkit import claims

ROWS = [(claim.paper, claim.id) for claim in claims.load()]


@cache
def outcomes(paper):
    """One recomputation per paper, row id to outcome."""
    return {outcome.claim.id: outcome for outcome in claims.recompute(paper)}


@pytest.mark.parametrize(("paper", "row"), ROWS, ids=[row for _, row in ROWS])
def test_row_carries_its_status(paper, row):
    assert outcomes(paper)[row].problem is None
