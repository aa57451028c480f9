"""``verify``: does a result agree with what is known, or with another result?"""

from argparse import Namespace
from pathlib import Path

import numpy as np
from scipy.stats import chi2, norm

from fogkit.cli.files import described, read_text, versions
from fogkit.cli.results import Estimates, Result
from fogkit.io.errors import RecordingError
from fogkit.io.verdicts import Finding

UNLIKELY = 1e-4
"""Probability of as large a departure by chance below which results disagree."""


def verify(args: Namespace) -> Result:
    """Difference of two results, quantity by quantity and all together, against their uncertainty."""
    paths = [Path(args.result), Path(args.reference)]
    result, reference = (Result.from_json(read_text(path), name=path.name) for path in paths)
    ours, theirs = result.estimates, reference.estimates
    common = [name for name in ours.names if name in theirs.names]
    if not common:
        raise RecordingError(f"{paths[0].name} and {paths[1].name} have no quantity in common")
    if ours.covariance is None:
        raise RecordingError(f"{paths[0].name} has no covariance: nothing says how large a difference may be")
    i, j = ([e.names.index(name) for name in common] for e in (ours, theirs))
    units = [ours.units[k] for k in i]
    if other := [n for n, u, k in zip(common, units, j, strict=True) if theirs.units[k] != u]:
        raise RecordingError(f"the unit of {other[0]} differs between the two results")
    covariance = ours.covariance[np.ix_(i, i)]
    if theirs.covariance is not None:
        covariance = covariance + theirs.covariance[np.ix_(j, j)]
    difference = ours.values[i] - theirs.values[j]
    deviation = np.sqrt(np.diagonal(covariance))
    if not (np.isfinite(deviation) & (deviation > 0) & np.isfinite(difference)).all():
        bad = common[int(np.argmin(np.isfinite(deviation) & (deviation > 0) & np.isfinite(difference)))]
        raise RecordingError(f"nothing is known of the uncertainty of {bad}")
    ratio = difference / deviation
    # correlation and not covariance: units differ by ten orders
    correlation = covariance / np.outer(deviation, deviation)
    chi_square = float(ratio @ np.linalg.solve(correlation, ratio))
    together = float(chi2.sf(chi_square, len(common)))
    worst = int(np.argmax(np.abs(ratio)))
    alone = float(-np.expm1(len(common) * np.log1p(-2 * norm.sf(abs(ratio[worst])))))  # largest of so many
    findings = [
        _finding(
            "all together", f"chi-square {chi_square:.4g} of {len(common)} quantities, p = {together:.2g}", together
        ),
        _finding(
            "largest", f"{common[worst]} departs by {ratio[worst]:.2f} standard deviations, p = {alone:.2g}", alone
        ),
    ]
    left_out = [name for name in (*ours.names, *theirs.names) if name not in common]
    if left_out:
        text = f"{len(left_out)} quantities are in one of the results only and were not compared: {left_out[0]}, ..."
        findings.append(Finding(check="common", severity="good", text=text, count=len(left_out)))
    return Result(
        command="verify",
        estimates=Estimates(names=common, units=units, values=difference, covariance=covariance),
        findings=findings,
        inputs=[described(path) for path in paths],
        parameters={"chi_square": chi_square, "p_value": together},
        versions=versions(),
        tables={"departures": {"name": common, "departure": ratio}},
    )


def _finding(check: str, text: str, probability: float) -> Finding:
    severity = "bad" if probability < UNLIKELY else "good"
    return Finding(check=check, severity=severity, text=text)
