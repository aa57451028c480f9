"""Four methods of calibration, each carried out on a stand in simulation as its own module has it.

What a method believes of the stand is that it is ideal. Gyros are calibrated by the method; accelerometers by the
method too if it sees them, else in six positions on a plate of the same quality.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration import multiposition, rate_sequence, three_stage
from fogkit.calibration import navigation_based as navigation
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.imu.constructions import Construction
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit
from fogkit.instrument.description import bench_triad
from fogkit.instrument.stands import Stand
from fogkit.results import FrozenArrays
from fogkit.stand import bench, placements, plans
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import observations
from fogkit.stand.placements import Schedule
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import bias_test, nine_tests
from fogkit.units import DEG, MINUTE

Array = NDArray[np.float64]

METHODS = ("none", "three-stage", "positions", "rate sequence", "navigation")
"""No calibration; three-axis table (volynskii); 24 points and six turns on a plate; rates about each axis on a
single-axis table (beihang, both); nine tests and a bias test on a turntable of two axes (klimkovich)."""

SAMPLE_RATE = 1.0
"""Samples per second on a plate: means of samples are all that these methods use."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibrated(FrozenArrays):
    """What a method found.

    Attributes
    ----------
    method : str
        One of `METHODS`.
    compensation : Compensation
        Of the linear errors of all six sensors.
    asymmetry : ndarray, shape (3,)
        Of the gyros' scale factors; 0 where the method does not look for it.
    duration : float
        Time of all readings of the gyros, s.
    """

    method: str
    compensation: Compensation
    asymmetry: Array
    duration: float


def calibrate(
    method: str, unit: MeasurementUnit, stand: Stand, latitude: float, rng: np.random.Generator
) -> Calibrated:
    """Calibrate a unit.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    unit : MeasurementUnit
        As it is on the stand: `Instrument.at` the conditions there.
    stand : Stand
        Whose errors are drawn.
    latitude : float
        rad.
    rng : numpy.random.Generator
        Source of the stand's errors and of all noise.

    Returns
    -------
    Calibrated
        What the method found.

    Raises
    ------
    ValueError
        If the method is none of them.
    """
    checks.option("method", method, METHODS)
    checks.instance("unit", unit, MeasurementUnit)
    checks.instance("stand", stand, Stand)
    found = _CARRIED_OUT[method](unit, stand, latitude, checks.generator("rng", rng))
    return Calibrated(method=method, **found)


def _none(unit, stand, latitude, rng) -> dict:
    return {"compensation": Compensation(), "asymmetry": np.zeros(3), "duration": 0.0}


def _three_stage(unit, stand, latitude, rng) -> dict:
    plan = plans.three_stage(Construction(name="plain"), bias_duration=15 * MINUTE)
    written = bench.run(plan, bench_triad(unit), stand.rate_table(latitude, rng), rng=rng)
    triad = three_stage.calibrate(written).triad
    equivalents = 0.5 * (1 / np.array(triad.scale_positive) + 1 / np.array(triad.scale_negative))
    gyros = LinearTriad.from_equivalents(triad.bias, equivalents, triad.A_g)
    on_plate = _accelerometers(unit, stand.laboratory(latitude, rng), rng)
    # asymmetry of readings: that of rad/s per reading has the other sign
    return _found(gyros, on_plate, -triad.asymmetry, plan.duration)


def _positions(unit, stand, latitude, rng) -> dict:
    schedule = placements.twenty_four_points(2 * MINUTE) + placements.full_turns(10 * DEG)
    # the operator turns by an angle, whatever the rate
    seen = _seen(unit, replace(stand.laboratory(latitude, rng), rate_error=0.0), schedule, rng)
    gyros = multiposition.calibrate_gyros(multiposition.averages_and_differences(seen, schedule)).triad
    averaged = multiposition.average_positions(seen, schedule)
    return _found(gyros, multiposition.calibrate_accelerometers(averaged).triad, np.zeros(3), schedule.duration)


def _rate_sequence(unit, stand, latitude, rng) -> dict:
    place = stand.laboratory(latitude, rng)
    sequence, east = placements.rate_sequence(duration=1 * MINUTE), placements.three_positions_east(10 * MINUTE)
    seen = _seen(unit, place, sequence, rng)
    fits = [
        rate_sequence.fit_scale_factor(seen, sequence, axis, terms=("asymmetry",), rate_error=stand.rate)
        for axis in range(3)
    ]
    scale = np.array([fit.scale_factor for fit in fits])
    misalignment = rate_sequence.installation(seen, sequence).triad.misalignment
    biases = rate_sequence.bias_from_east(_seen(unit, place, east, rng), east, scale, Laboratory(latitude=latitude))
    gyros = LinearTriad(bias=biases.bias, matrix=scale[:, np.newaxis] * (np.eye(3) + misalignment))
    asymmetry = np.array([fit.coefficient("asymmetry")[0] for fit in fits])
    return _found(gyros, _accelerometers(unit, place, rng), asymmetry, sequence.duration + east.duration)


def _navigation(unit, stand, latitude, rng) -> dict:
    table, tests = stand.rough_table(latitude), nine_tests()
    recordings = record(unit, table.motions(tests, rng), rng=rng)
    matrices = navigation.calibrate(recordings, tests, latitude, initial_attitude="levelled").compensation
    last = bias_test(dwell=10 * MINUTE)
    (rest,) = record(unit, table.motions([last], rng), rate=20.0, rng=rng)
    found = navigation.estimate_gyro_biases(rest, last, matrices, latitude, method="rates")
    duration = sum(test.duration for test in (*tests, last))
    return {"compensation": found.compensation, "asymmetry": np.zeros(3), "duration": duration}


_CARRIED_OUT: dict[str, Callable] = dict(
    zip(METHODS, (_none, _three_stage, _positions, _rate_sequence, _navigation), strict=True)
)


def _seen(unit: MeasurementUnit, place: Laboratory, schedule: Schedule, rng: np.random.Generator):
    """Mean readings of a schedule, with inputs of an ideal stand at the place."""
    recording = place.record(unit, schedule, rng, sample_rate=SAMPLE_RATE)
    random = (unit.gyros.random, unit.accelerometers.random)
    return observations(recording, schedule, Laboratory(latitude=place.latitude), random=random)


def _accelerometers(unit: MeasurementUnit, place: Laboratory, rng: np.random.Generator) -> LinearTriad:
    """Accelerometers in six positions of four headings."""
    schedule = placements.twenty_four_points(1 * MINUTE)
    averaged = multiposition.average_positions(_seen(unit, place, schedule, rng), schedule)
    return multiposition.calibrate_accelerometers(averaged).triad


def _found(gyros: LinearTriad, accelerometers: LinearTriad, asymmetry: Array, duration: float) -> dict:
    """Fields of `Calibrated` from the sensors as they were found."""
    parts = {}
    for kind, triad in (("gyro", gyros), ("accelerometer", accelerometers)):
        matrix = np.linalg.inv(triad.matrix)
        parts |= {f"{kind}_matrix": matrix, f"{kind}_bias": -matrix @ np.array(triad.bias)}
    return {"compensation": Compensation(**parts), "asymmetry": asymmetry, "duration": duration}
