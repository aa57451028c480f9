"""``calibrate three-stage`` and ``navigation``: turns on a rate table, and on a rough one."""

from argparse import Namespace
from typing import Any

import numpy as np

from fogkit.calibration.triad import PARAMETERS
from fogkit.cli.corrections import compensation_correction, triad_correction
from fogkit.cli.loading import Loaded, load
from fogkit.cli.placed_calibrations import residual_finding
from fogkit.cli.results import Estimates, Result, table_of
from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.handover import bench_record, turn_tables
from fogkit.io.verdicts import Finding
from fogkit.noise import RandomErrors, identify
from fogkit.units import ARCSEC, DEG_PER_SQRT_HOUR, MICRO_G

SCALE_UNIT = "1"  # rad/s of input per rad/s of reading


def three_stage(args: Namespace) -> Result:
    """Fifteen parameters of a gyro triad from four bias positions and whole turns about each axis."""
    from dataclasses import replace

    from fogkit.calibration import three_stage as method
    from fogkit.stand.table import RateTable

    loaded = load(args.recording, ("three-stage",), "calibrate three-stage")
    record = bench_record(loaded.recording, loaded.segmentation, loaded.plan)
    walk, finding = _white(loaded, GYRO_COLUMNS, args.gyro_noise, DEG_PER_SQRT_HOUR, "deg/sqrt(h)")
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
    gyro, first = _white(loaded, GYRO_COLUMNS, args.gyro_noise, DEG_PER_SQRT_HOUR, "deg/sqrt(h)")
    accel, second = _white(loaded, ACCEL_COLUMNS, args.accel_noise, MICRO_G, "ug/sqrt(Hz)")
    noise = SensorNoise(
        gyros=RandomErrors(angle_random_walk=gyro), accelerometers=RandomErrors(angle_random_walk=accel)
    )
    R = plan_covariance(plan, loaded.recording.dt, noise, scale_factors=True)
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
            units=["m/s^2" if name.startswith("B_a") else "rad/s" if name.startswith("B_g") else "1" for name in frame.index],
            values=frame["value"].to_numpy(),
            covariance=found.solution.covariance[np.ix_(order, order)],
        ),
        findings=findings,
        parameters={"angle_random_walk": gyro, "velocity_random_walk": accel, "iterations": args.iterations},
        tables={"iterations": table_of(found.log), "slopes": _slopes(found.slopes)},
        correction=compensation_correction(found.compensation),
    )


def _white(
    loaded: Loaded, columns: tuple[str, ...], given: float | None, factor: float, unit: str
) -> tuple[float, Finding]:
    """White noise of three sensors: as given, or as the longest dwell shows it, with what is to be said of that."""
    sensor = "gyros" if columns == GYRO_COLUMNS else "accelerometers"
    if given is not None:
        return given * factor, Finding(check="noise", severity="good", text=f"{given:g} {unit} of the {sensor}, as given")
    dwells = [s for s in loaded.segmentation.segments if s.kind == "dwell"]
    longest = max(dwells, key=lambda s: s.duration)
    table = loaded.recording.table[list(columns)].iloc[longest.first : longest.last]
    values = table.to_numpy(dtype=float)
    margin = 0 if loaded.segmentation.exact else max(1, len(values) // 20)  # part of an edge may be motion
    values = values[margin : len(values) - margin]
    found = [identify(values[:, i], loaded.recording.dt, processes=("angle_random_walk",)) for i in range(3)]
    walk = float(np.sqrt(np.mean([f.estimate.angle_random_walk**2 for f in found])))
    text = f"{walk / factor:.3g} {unit} of the {sensor}, white, from the longest dwell of {longest.duration:.4g} s"
    if min(f.p_value for f in found) < 1e-3:
        text += ": it is not white alone, so standard deviations are too small; give another with an option"
        return walk, Finding(check="noise", severity="doubtful", text=text)
    return walk, Finding(check="noise", severity="good", text=text)


def _slopes(frame: Any) -> dict[str, Any]:
    """Slopes of both dwells of each test as columns."""
    flat = frame.reset_index()
    return {str(c): flat[c].to_numpy() for c in flat.columns}
