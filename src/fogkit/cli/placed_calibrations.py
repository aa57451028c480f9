"""``calibrate multiposition`` and ``rate-sequence``: mean readings of placements whose inputs the plan tells."""

from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fogkit.calibration import multiposition as method
from fogkit.calibration import rate_sequence as rates
from fogkit.cli.corrections import linear_correction
from fogkit.cli.loading import load
from fogkit.cli.results import Estimates, Result, table_of
from fogkit.estimation import Solution
from fogkit.imu.triads import AXES, LinearTriad
from fogkit.io.errors import RecordingError
from fogkit.io.handover import placed
from fogkit.io.verdicts import Finding
from fogkit.stand.means import Observations, observations
from fogkit.units import DEG_PER_SECOND

if TYPE_CHECKING:
    from fogkit.calibration.multiposition import LinearCalibration

PLACEMENT_PLANS = ("placements", "six-positions", "twenty-four-points", "full-turns")

UNLIKELY = 1e-3
"""Probability of a larger chi-square below which residuals are called larger than the noise explains."""


def multiposition(args: Namespace) -> Result:
    """Biases and matrices of accelerometers, and of gyros if the plan has turns, from positions."""
    loaded = load(args.recording, PLACEMENT_PLANS, "calibrate multiposition")
    table, schedule = placed(loaded.recording, loaded.segmentation, loaded.plan)
    observed = observations(table, schedule, loaded.laboratory)
    found: dict[str, LinearCalibration] = {}
    findings = []
    if any(p.rate == 0 for p in schedule.placements):
        found["accel"] = method.calibrate_accelerometers(observed)
    if any(p.rate for p in schedule.placements):
        found["gyro"] = method.calibrate_gyros(observed)
    else:
        text = "the plan has no turns: gyros were not calibrated, add them with `full-turns` or `placements`"
        findings.append(Finding(check="plan", severity="doubtful", text=text))
    estimates, tables = Estimates(), {}
    for sensor, calibration in found.items():
        for axis, solution in zip(AXES, calibration.solutions, strict=True):
            estimates = estimates.joined(_of_solution(sensor, solution))
            findings.append(residual_finding(f"{sensor}_{axis}", solution))
        tables[f"residuals {sensor}"] = _residuals(observed, calibration.solutions)
    return loaded.result(
        "calibrate multiposition",
        estimates=estimates,
        findings=findings,
        tables={"means": table_of(observed.to_frame())} | tables,
        correction=linear_correction(
            None if "gyro" not in found else found["gyro"].triad,
            None if "accel" not in found else found["accel"].triad,
        ),
    )


def rate_sequence(args: Namespace) -> Result:
    """Scale factor, bias and shape of each gyro from a sequence of rates, and the directions of the input axes.

    Directions come from the turns of all axes at one rate. Their covariance with scale factors is left at zero: a
    gyro's direction follows from turns about the other axes, its scale factor from those about its own.
    """
    loaded = load(args.recording, ("rate-sequence",), "calibrate rate-sequence")
    table, schedule = placed(loaded.recording, loaded.segmentation, loaded.plan)
    observed = observations(table, schedule, loaded.laboratory)
    turned = sorted({p.vertical[0] for p in schedule.placements})
    estimates, findings, tables = Estimates(), [], {}
    matrix, bias = np.eye(3), np.zeros(3)
    for axis in turned:
        fit = rates.fit_scale_factor(observed, schedule, axis, terms=args.term, rate_error=args.rate_error)
        estimates = estimates.joined(_of_fit(fit))
        findings.append(residual_finding(f"gyro_{AXES[axis]}", fit.solution))
        tables[f"rates gyro_{AXES[axis]}"] = table_of(fit.to_frame())
        matrix[axis, axis], bias[axis] = fit.scale_factor, fit.intercept * fit.scale_factor
    rate = _common_rate(schedule.placements, args.installation_rate)
    if rate is None:
        text = "no rate was turned both ways about all axes: directions of the input axes are taken as nominal"
        findings.append(Finding(check="plan", severity="doubtful", text=text))
    else:
        directions = rates.installation(observed, schedule, rate=rate)
        estimates = estimates.joined(_of_directions(directions))
        misalignment = np.array(directions.triad.misalignment)
        matrix = np.diagonal(matrix)[:, None] * (np.eye(3) + misalignment)
    if args.term:
        text = f"`apply` corrects scale factor, bias and directions; it leaves {', '.join(args.term)} in"
        findings.append(Finding(check="correction", severity="doubtful", text=text))
    return loaded.result(
        "calibrate rate-sequence",
        estimates=estimates,
        findings=findings,
        parameters={"terms": list(args.term), "rate_error": args.rate_error, "installation_rate": rate},
        tables=tables,
        correction=linear_correction(LinearTriad(bias=bias, matrix=matrix), None) if len(turned) == 3 else None,
    )


def residual_finding(channel: str, solution: Solution) -> Finding:
    """Whether the residuals of a fit are noise."""
    if not solution.degrees_of_freedom:
        text = "as many readings as parameters: nothing says whether the model fits"
        return Finding(check="residuals", severity="doubtful", text=text, channel=channel)
    p = solution.p_value
    text = f"chi-square {solution.chi_square:.4g} with {solution.degrees_of_freedom} degrees of freedom, p = {p:.2g}"
    if p >= UNLIKELY:
        return Finding(check="residuals", severity="good", text=text, channel=channel)
    ratio = np.sqrt(solution.chi_square / solution.degrees_of_freedom)
    text += (
        f": errors of the table or the unit's shape are {ratio:.3g} times the noise, so standard deviations are too "
    )
    return Finding(check="residuals", severity="doubtful", text=text + "small", channel=channel)


def _of_solution(sensor: str, solution: Solution) -> Estimates:
    """Estimates of one sensor of a linear calibration."""
    unit = {"accel": "m/s^2", "gyro": "rad/s"}[sensor]
    return Estimates(
        names=[f"{sensor}.{name}" for name in solution.names],
        units=[unit if name.startswith("bias") else "1" for name in solution.names],
        values=solution.estimate,
        covariance=solution.covariance,
    )


def _of_fit(fit: rates.ScaleFactorFit) -> Estimates:
    """Scale factor, bias as a rate, and terms over the scale factor, with their covariance."""
    solution, scale = fit.solution, fit.scale_factor
    values = np.array(solution.estimate)
    values[1:] /= scale
    slopes = np.eye(len(values))
    slopes[1:, 1:] /= scale
    slopes[1:, 0] = -values[1:] / scale
    powers = {"asymmetry": "1", "quadratic": "s/rad", "cubic": "s^2/rad^2"}
    axis = AXES[fit.axis]
    return Estimates(
        names=[f"gyro.{name}_{axis}" for name in ("scale_factor", "input_bias", *fit.terms)],
        units=["1", "rad/s", *(powers[term] for term in fit.terms)],
        values=values,
        covariance=slopes @ solution.covariance @ slopes.T,
    )


def _of_directions(calibration: "LinearCalibration") -> Estimates:
    """Misalignments across the nominal axes, rad."""
    places = [(i, j) for i in range(3) for j in range(3) if i != j]
    triad, names, values, variances = calibration.triad, [], [], []
    for i, j in places:
        names.append(f"gyro.misalignment_{AXES[i]}{AXES[j]}")
        values.append(triad.misalignment[i][j])
        variances.append(calibration.misalignment_deviation[i, j] ** 2)
    return Estimates(names=names, units=["rad"] * 6, values=values, covariance=np.diag(variances))


def _common_rate(placements: Sequence[Any], wanted: float | None) -> float | None:
    """Rate that was turned both ways about x, y and z: the one wanted, 150 deg/s, or else the largest."""
    turned: dict[float, set] = {}
    for p in placements:
        if p.rate:
            turned.setdefault(round(abs(p.rate), 9), set()).add((p.vertical[0], p.vertical[1] * p.rate > 0))
    there = sorted(rate for rate, ways in turned.items() if len(ways) == 6)
    exact = {round(abs(p.rate), 9): abs(p.rate) for p in placements}
    if wanted is not None:
        near = [rate for rate in there if np.isclose(rate, wanted, rtol=1e-6)]
        if not near:
            raise RecordingError(
                f"the plan has no turns at {wanted / DEG_PER_SECOND:g} deg/s both ways about each axis"
            )
        return exact[near[0]]
    usual = [rate for rate in there if np.isclose(rate, 150 * DEG_PER_SECOND)]
    return exact[(usual or there)[-1]] if there else None


def _residuals(observed: Observations, solutions: Sequence[Solution]) -> dict[str, Any]:
    """Residuals over their standard deviations, by position, where all sensors have all positions."""
    columns = {"position": list(observed.labels)}
    if any(len(s.whitened_residuals) != len(observed.labels) for s in solutions):
        return {}
    return columns | {axis: s.whitened_residuals for axis, s in zip(AXES, solutions, strict=True)}
