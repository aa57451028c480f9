"""The paper's procedure carried out on the simulated bench: recovery of injected truth, and complete error budgets."""

from __future__ import annotations

from functools import cache

import numpy as np

from fogkit.calibration import three_stage
from fogkit.calibration.triad import parameters_of
from fogkit.imu import Construction, GyroTriad
from fogkit.reproduction.volynskii import instruments as paper
from fogkit.reproduction.volynskii.simulation import ASSUMED_LATITUDE
from fogkit.stand import RateTable, bench, plans
from fogkit.units import ARCMIN, ARCSEC, DEG_PER_SECOND

SEED = 20110316
RUNS = 2000


def example_triad(**noise) -> GyroTriad:
    """Gyros with the means of the paper's tables 1 to 3 (gamma_xz in arcmin), and noise as given."""
    names = ("yx", "zx", "xy", "zy", "xz", "yz")
    plus, minus = (np.array([paper.TABLE_2[f"{axis}{sign}"]["mean"] for axis in "xyz"]) for sign in "+-")
    return GyroTriad(
        scale_positive=plus,
        scale_negative=minus,
        misalignments=[paper.TABLE_3[name]["mean"] * ARCMIN for name in names],
        **noise,
    )


def recovers(name: str) -> bool:
    """Whether the one plan and the one code path give back what was put in, without noise, for a construction.

    Scale factors to 1e-9, directions to 1e-6 arcsec, at the paper's largest misalignments.
    """
    rng = np.random.default_rng(SEED)
    angles = rng.uniform(-1, 1, 6) * paper.MISALIGNMENT_LIMIT
    triad = GyroTriad(
        scale_positive=(1.746892, 1.664746, 1.730345),
        scale_negative=(1.746890, 1.664747, 1.730357),
        misalignments=angles,
    )
    record = bench.run(plans.three_stage(Construction(name=name)), triad, RateTable(latitude=ASSUMED_LATITUDE))
    error = three_stage.calibrate(record).estimate - parameters_of(triad)
    return bool(np.abs(error[3:9]).max() < 1e-9 * 1.7 and np.abs(error[9:]).max() < 1e-6 * ARCSEC)


@cache
def deviations_of_a_complete_calibration() -> dict[str, float]:
    """Monte Carlo of the whole procedure with the paper's noise, a mounting of 3 arcsec and axes 6 arcsec off.

    Returns
    -------
    dict of float
        Largest standard deviation over the three gyros: ``scale`` and ``asymmetry``, relative; ``angle``, of the gyros'
        directions against the case, and ``angle_on_table``, without the errors of mounting and table, rad.
    """
    rng = np.random.default_rng(SEED)
    # the bias that remains after an hour is drawn anew for each reading of the triad
    triad = example_triad(angle_random_walk=paper.EXAMPLE_NOISE, bias_instability=paper.EXAMPLE_BIAS_ERROR)
    rates = (36 * DEG_PER_SECOND, -36 * DEG_PER_SECOND)
    plan = plans.three_stage(Construction(name="plain"), bias_duration=paper.BIAS_DURATION, rates=rates, count=36)
    table = RateTable(
        latitude=ASSUMED_LATITUDE, readout_noise=paper.EXAMPLE_READOUT, rate_stability=paper.TABLE_RATE_STABILITY
    )
    still = three_stage.calibrate(bench.run(plan, triad, table, rng=rng, runs=RUNS))
    angle = still.estimate[:, 9:].std(axis=0)
    errors = rng.standard_normal((200, 8)) * _table_errors()
    shifted = [
        three_stage.calibrate(bench.run(plan, triad, table.with_geometry(error))).estimate[9:] for error in errors
    ]
    return {
        "scale": float((still.estimate[:, 3:9].std(axis=0) / still.estimate[0, 3:9]).max()),
        "asymmetry": float(still.asymmetry.std(axis=0).max()),
        "angle_on_table": float(angle.max()),
        "angle": float(np.hypot(angle, np.std(shifted, axis=0)).max()),
    }


def _table_errors() -> np.ndarray:
    """Standard deviations of the table's geometry, rad: bounds of the paper, taken as one sigma."""
    level, azimuth = paper.TABLE_POSITIONING, paper.AZIMUTH_ERRORS[0]
    return np.array([level, level, azimuth, *[paper.TABLE_NONORTHOGONALITY] * 2, *[paper.SMALL_ANGLES[1]] * 3])
