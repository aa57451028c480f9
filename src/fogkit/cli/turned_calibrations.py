"""``calibrate three-stage`` and ``navigation``: turns on a rate table, and on a rough one."""

from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.triad import PARAMETERS
from fogkit.cli.corrections import compensation_correction, triad_correction
from fogkit.cli.loading import load
from fogkit.cli.placed_calibrations import residual_finding
from fogkit.cli.results import Estimates, Result, table_of
from fogkit.constants import EARTH_RATE
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.handover import bench_record, turn_tables
from fogkit.io.verdicts import Finding
from fogkit.noise import RandomErrors, identify
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import ARCSEC, DEG, DEG_PER_SQRT_HOUR, MICRO_G

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

NOISE_UNITS = {"gyros": (DEG_PER_SQRT_HOUR, "deg/sqrt(h)"), "accelerometers": (MICRO_G, "ug/sqrt(Hz)")}

UNLIKELY = 1e-3
"""Probability of a larger chi-square, of the worst of all stretches, below which noise is not white alone."""

SCALE_UNIT = "1"  # rad/s of input per rad/s of reading


def three_stage(args: Namespace) -> Result:
    """Fifteen parameters of a gyro triad from four bias positions and whole turns about each axis."""
    from dataclasses import replace

    from fogkit.calibration import three_stage as method
    from fogkit.stand.table import RateTable

    loaded = load(args.recording, ("three-stage",), "calibrate three-stage")
    record = bench_record(loaded.recording, loaded.segmentation, loaded.plan)
    gyros = loaded.recording.table[list(GYRO_COLUMNS)].to_numpy(dtype=float)
    margin = 0 if loaded.segmentation.exact else 1 + round(loaded.segmentation.windows.duration / loaded.recording.dt)
    found = loaded.segmentation.labelled()
    rests = [found[s.label] for s in loaded.plan.segments if s.turning is None]
    dwells = [gyros[s.first + margin : s.last - margin] for s in rests]
    walk, finding = _white(dwells, loaded.recording.dt, args.gyro_noise, "gyros")
    first = method.calibrate(record)
    triad = replace(first.triad, angle_random_walk=walk)
    table = RateTable(latitude=loaded.latitude, readout_noise=args.readout_noise * ARCSEC)
    found = method.calibrate(record, noise=(triad, table))
    units = ["rad/s"] * 3 + [SCALE_UNIT] * 6 + ["rad"] * 6
    names = [f"gyro.{name}" for name in PARAMETERS]
    return loaded.result(
        "calibrate three-stage",
        estimates=Estimates(names=names, units=units, values=found.estimate, covariance=found.covariance),
        findings=[finding],
        parameters={"angle_random_walk": walk, "readout_noise": table.readout_noise},
        tables={"means": table_of(record.to_frame())},
        correction=triad_correction(found),
    )


def navigation(args: Namespace) -> Result:
    """Accelerometer biases and both matrices from changes of the computed velocity over turns on a rough table."""
    from fogkit.calibration.navigation_based import calibrate
    from fogkit.calibration.uncertainty import plan_covariance
    from fogkit.calibration.velocity_noise import SensorNoise

    loaded = load(args.recording, ("nine-tests",), "calibrate navigation")
    plan = loaded.plan
    tables = turn_tables(loaded.recording, loaded.segmentation, plan)
    dt = loaded.recording.dt
    gyro, first = _white(_dwells(tables, plan, GYRO_COLUMNS, dt), dt, args.gyro_noise, "gyros")
    accel, second = _white(_dwells(tables, plan, ACCEL_COLUMNS, dt), dt, args.accel_noise, "accelerometers")
    noise = SensorNoise(
        gyros=RandomErrors(angle_random_walk=gyro), accelerometers=RandomErrors(angle_random_walk=accel)
    )
    R = plan_covariance(plan, dt, noise, scale_factors=True)
    R[: 2 * len(plan), : 2 * len(plan)] += heading_covariance(
        plan, loaded.latitude, args.azimuth_error * DEG, args.start_error * DEG
    )
    gravity = loaded.recording.description.gravity
    found = calibrate(
        tables,
        plan,
        loaded.latitude,
        gravity=gravity,
        initial_attitude="levelled",
        scale_factor="all",
        iterations=args.iterations,
        noise=R,
    )
    findings = [first, second, residual_finding("", found.solution)]
    if not found.converged:
        text = f"the iteration did not settle in {args.iterations}: give more with --iterations"
        findings.append(Finding(check="convergence", severity="doubtful", text=text))
    frame = found.to_frame()
    order = [found.solution.index(name.lower()) for name in frame.index]
    return loaded.result(
        "calibrate navigation",
        estimates=Estimates(
            names=list(frame.index),
            units=[
                "m/s^2" if name.startswith("B_a") else "rad/s" if name.startswith("B_g") else "1"
                for name in frame.index
            ],
            values=frame["value"].to_numpy(),
            covariance=found.solution.covariance[np.ix_(order, order)],
        ),
        findings=findings,
        parameters={
            "angle_random_walk": gyro,
            "velocity_random_walk": accel,
            "iterations": args.iterations,
            "azimuth_error": args.azimuth_error * DEG,
            "start_error": args.start_error * DEG,
        },
        tables={"iterations": table_of(found.log), "slopes": _slopes(found.slopes)},
        correction=compensation_correction(found.compensation),
    )


def heading_covariance(plan: Sequence[TurnTest], latitude: float, azimuth: float, start: float) -> Array:
    """Covariance of the measurements of a plan from headings that are not known.

    Parameters
    ----------
    plan : sequence of TurnTest
        The tests.
    latitude : float
        rad.
    azimuth, start : float
        Standard deviations, rad, of the heading of the table, common to all tests, and of each test's own.

    Returns
    -------
    ndarray, shape (2 n, 2 n)
        Differences of the slopes east and north of each test, (m/s^2)^2.

    Notes
    -----
    A heading that is wrong by a small angle d takes ``d Omega cos(latitude)`` of the Earth's level rate for a rate
    about east. Over the time T between the middles of the dwells the computed vertical tilts by T times that, and the
    slope of the velocity north changes by gravity times the tilt: nothing else in the data tells it from calibration.
    """
    from fogkit.earth import normal_gravity

    times = np.array([0.5 * (test.dwell + test.dwell_after) + test.turn_duration for test in plan])
    slope = np.zeros(2 * len(plan))
    slope[1::2] = normal_gravity(latitude) * EARTH_RATE * np.cos(latitude) * times
    return azimuth**2 * np.outer(slope, slope) + start**2 * np.diag(slope**2)


def _white(rests: Sequence[Array], dt: float, given: float | None, sensors: str) -> tuple[float, Finding]:
    """White noise of three sensors: as given, or as stretches of rest show it, with what is to be said of that."""
    factor, unit = NOISE_UNITS[sensors]
    if given is not None:
        text = f"{given:g} {unit} of the {sensors}, as given"
        return given * factor, Finding(check="noise", severity="good", text=text)
    found = [identify(rest[:, i], dt, processes=("angle_random_walk",)) for rest in rests for i in range(3)]
    walk = float(np.sqrt(np.mean([f.estimate.angle_random_walk**2 for f in found])))
    text = f"{walk / factor:.3g} {unit} of the {sensors}, white, from {len(rests)} stretches of rest"
    if min(f.p_value for f in found) * len(found) < UNLIKELY:
        text += ": it is not white alone, so standard deviations are too small; give another with an option"
        return walk, Finding(check="noise", severity="doubtful", text=text)
    return walk, Finding(check="noise", severity="good", text=text)


def _dwells(
    tables: "Sequence[DataFrame]", plan: Sequence[TurnTest], columns: tuple[str, ...], dt: float
) -> list[Array]:
    """Readings in the first dwell of each test."""
    return [
        table[list(columns)].to_numpy(dtype=float)[: round(test.dwell / dt)] / dt
        for table, test in zip(tables, plan, strict=True)
    ]


def _slopes(frame: Any) -> dict[str, Any]:
    """Slopes of both dwells of each test as columns."""
    flat = frame.reset_index()
    return {str(c): flat[c].to_numpy() for c in flat.columns}
