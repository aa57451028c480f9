"""The slides' two laboratory methods on an example unit: what their claimed advantages and weaknesses amount to.

The slides give no unit, no place and no errors of plate or cube; those here are assumptions, of the size of a unit for
land navigation. Every function takes others.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration import multiposition, rate_sequence
from fogkit.calibration.multiposition import LinearCalibration
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors, Shape
from fogkit.noise.processes import RandomErrors
from fogkit.stand import placements
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import Observations, expected_inputs, observations, with_inputs
from fogkit.stand.placements import Schedule
from fogkit.units import (
    ARCMIN,
    ARCSEC,
    DEG,
    DEG_PER_HOUR,
    DEG_PER_HOUR_PER_G,
    DEG_PER_SECOND,
    DEG_PER_SQRT_HOUR,
    MICRO_G,
    MICRO_G_PER_SQRT_HZ,
    MILLI_G,
    MINUTE,
    PPM,
)

PLACE = Laboratory(latitude=40 * DEG)
"""Where the examples stand."""

GYRO_NOISE = RandomErrors(angle_random_walk=0.005 * DEG_PER_SQRT_HOUR, bias_instability=0.01 * DEG_PER_HOUR)
ACCELEROMETER_NOISE = RandomErrors(angle_random_walk=20 * MICRO_G_PER_SQRT_HZ, bias_instability=10 * MICRO_G)
"""Random errors of the example: gyros in rad, accelerometers in m/s."""

GYRO_PULSE = 0.1 * ARCSEC
ACCELEROMETER_PULSE = 50 * MICRO_G
"""What one pulse of a gyro, rad, and of an accelerometer, m/s, stands for."""

GYRO_SHAPE = Shape(asymmetry=(5 * PPM, -8 * PPM, 3 * PPM), cubic=np.array([4.0, -3.0, 2.0]) * PPM)
"""Scale factors of the example: the cubic term makes some 50 ppm at 200 deg/s."""

MECHANICAL = np.array([[2.0, -0.5, 0.3], [0.4, 1.5, -0.6], [-0.2, 0.5, 1.0]]) * DEG_PER_HOUR_PER_G
"""Acceleration-sensitive drift of mechanical gyros, rad/s per m/s^2, rows x, y, z: the slides' option."""


def example_unit(*, mechanical: bool = False, random: bool = True, shaped: bool = False) -> MeasurementUnit:
    """A unit with pulses, biases, scale factors and misalignments of ordinary size.

    Parameters
    ----------
    mechanical : bool, optional
        Whether its gyros are acceleration-sensitive.
    random : bool, optional
        Whether it has random errors and counts in whole pulses.
    shaped : bool, optional
        Whether the gyros' scale factors are asymmetric and nonlinear.

    Returns
    -------
    MeasurementUnit
        Readings in pulses per second.
    """
    gyros = LinearTriad.from_standard(
        scale_factor=np.array([1.0003, 0.9995, 1.0008]) / GYRO_PULSE,
        input_bias=np.array([0.8, -0.5, 0.3]) * DEG_PER_HOUR,
        misalignment=np.array([[0, 2.0, -3.0], [-1.5, 0, 4.0], [2.5, -1.0, 0]]) * ARCMIN,
    )
    accelerometers = LinearTriad.from_standard(
        scale_factor=np.array([0.9996, 1.0007, 1.0002]) / ACCELEROMETER_PULSE,
        input_bias=np.array([1.2, -0.7, 0.4]) * MILLI_G,
        misalignment=np.array([[0, -1.0, 2.0], [3.0, 0, -2.5], [-1.5, 0.8, 0]]) * ARCMIN,
    )
    if mechanical:
        gyros = replace(gyros, acceleration_sensitivity=gyros.scale_factor[:, None] * MECHANICAL)
    return MeasurementUnit(
        gyros=Sensors(
            triad=gyros,
            shape=GYRO_SHAPE if shaped else Shape(),
            random=GYRO_NOISE if random else RandomErrors(),
            pulse=float(random),
        ),
        accelerometers=Sensors(
            triad=accelerometers,
            random=ACCELEROMETER_NOISE if random else RandomErrors(),
            pulse=float(random),
        ),
    )


def noise_free(unit: MeasurementUnit, schedule: Schedule, actual: Laboratory, believed: Laboratory) -> Observations:
    """Observations without noise of a unit with constant scale factors, made in one place and read as in another."""
    omega, force = expected_inputs(schedule, actual)
    readings = np.hstack([unit.gyros.expected(omega, force), unit.accelerometers.expected(force)])
    return with_inputs(readings, schedule, believed)


def calibrate_both(
    observed: Observations, schedule: Schedule, *, averaged: bool = True, mechanical: bool = False
) -> tuple[LinearCalibration, LinearCalibration]:
    """Accelerometers and gyros from positions and turns, by the slides' way or without its averages.

    Parameters
    ----------
    observed, schedule
        Positions and opposite turns.
    averaged : bool, optional
        Whether positions are averaged over their headings first.
    mechanical : bool, optional
        Whether acceleration sensitivities are estimated.

    Returns
    -------
    accelerometers, gyros : LinearCalibration
        The results.
    """
    still = [i for i, placement in enumerate(schedule.placements) if placement.rate == 0]
    if averaged:
        at_rest = multiposition.average_positions(observed, schedule)
        everything = multiposition.averages_and_differences(observed, schedule)
    else:
        at_rest = observed.combine(np.eye(len(schedule))[still], [schedule.labels[i] for i in still])
        everything = at_rest.joined(multiposition.turn_differences(observed, schedule))
    return (
        multiposition.calibrate_accelerometers(at_rest),
        multiposition.calibrate_gyros(everything, acceleration_sensitivity=mechanical),
    )


DISTURBANCES = {
    "plate turned in azimuth": lambda size: {"azimuth_error": size},
    "plate tilted about east": lambda size: {"level_east": size},
    "plate tilted about north": lambda size: {"level_north": size},
    "unit turned in the cube": lambda size: {"mounting": np.array([0.7, -1.0, 0.4]) * size},
    "faces of the cube not square": lambda size: {"faces": FACES * size},
}
"""What disturbs a plan, as the errors of a laboratory for its size, rad."""

FACES = np.array([[0.0, 0.6, -0.8], [0, -0.9, 0.3], [0.7, 0, 0.5], [-0.4, 0, -0.6], [0.8, -0.2, 0], [-0.5, 0.9, 0]])
"""Tilts of the six faces of a cube, of mixed signs, in units of their size."""

GROUPS = {
    "accelerometer bias": MICRO_G,
    "accelerometer equivalent": PPM,
    "accelerometer cosines": ARCSEC,
    "gyro bias": DEG_PER_HOUR,
    "gyro equivalent": PPM,
    "gyro cosines": ARCSEC,
    "gyro acceleration sensitivity": DEG_PER_HOUR_PER_G,
}
"""The kinds of coefficients, each with the unit it is shown in."""

EXACT = 1e-9
"""Error, of the units of `GROUPS`, below which a coefficient counts as undisturbed: rounding."""


@dataclass(frozen=True, kw_only=True)
class Disturbed:
    """Error of one kind of coefficient from one disturbance.

    Attributes
    ----------
    error : float
        Largest of the kind, SI.
    order : int
        0: none; 1: proportional to the disturbance; 2: to its square.
    """

    error: float
    order: int


def disturbed(disturbance: str, size: float = ARCMIN, *, plan: str = "24 points") -> dict[str, Disturbed]:
    """What a disturbance does to each kind of coefficient, without noise.

    Parameters
    ----------
    disturbance : str
        One of `DISTURBANCES`.
    size : float, optional
        Its size, rad. The order is taken from this and half of it.
    plan : {"24 points", "six positions"}, optional
        Whether the four headings are averaged, or there is one heading and the plate is believed true.

    Returns
    -------
    dict
        By the names of `GROUPS`.
    """
    change = DISTURBANCES[checks.option("disturbance", disturbance, DISTURBANCES)]
    checks.option("plan", plan, ("24 points", "six positions"))
    size = checks.positive("size", size, "rad")
    whole, half = (_errors(replace(PLACE, **change(part)), plan) for part in (size, size / 2))
    result = {}
    for group, unit in GROUPS.items():
        ratio = whole[group] / half[group] if half[group] > 0 else 1.0
        order = 0 if whole[group] < EXACT * unit else max(1, round(float(np.log2(ratio))))
        result[group] = Disturbed(error=whole[group], order=order)
    return result


def _errors(actual: Laboratory, plan: str) -> dict[str, float]:
    """Largest error of each kind of coefficient, SI."""
    unit = example_unit(mechanical=True, random=False)
    points = placements.twenty_four_points() if plan == "24 points" else placements.six_positions()
    schedule = points + placements.full_turns()
    observed = noise_free(unit, schedule, actual, PLACE)
    found = calibrate_both(observed, schedule, averaged=plan == "24 points", mechanical=True)
    errors = {}
    for kind, calibration, sensors in zip(
        ("accelerometer", "gyro"), found, (unit.accelerometers, unit.gyros), strict=True
    ):
        estimated, true = calibration.triad, sensors.triad
        errors[f"{kind} bias"] = np.array(estimated.bias) / true.equivalents - np.array(true.bias) / true.equivalents
        errors[f"{kind} equivalent"] = estimated.equivalents / true.equivalents - 1
        errors[f"{kind} cosines"] = estimated.cosines - true.cosines
        sensitivity = np.array(estimated.acceleration_sensitivity) - np.array(true.acceleration_sensitivity)
        errors[f"{kind} acceleration sensitivity"] = sensitivity / true.equivalents[:, None]
    return {group: float(np.abs(errors[group]).max()) for group in GROUPS}


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a plan asks of the operator.

    Attributes
    ----------
    placements : int
        Times that the unit is laid down anew.
    reading : float
        Time of all readings, s.
    """

    placements: int
    reading: float

    def total(self, handling: float) -> float:
        """Time with `handling`, s, for each placement."""
        return self.reading + self.placements * handling


def efforts(point: float = 2 * MINUTE) -> dict[str, Effort]:
    """Both methods of the slides for a whole unit.

    Parameters
    ----------
    point : float, optional
        Duration of one of the 24 points, s, which the slides do not give.
    """
    points, turns = placements.twenty_four_points(point), placements.full_turns()
    cube = placements.six_positions() + placements.three_positions_east()
    rates = placements.rate_sequence()
    return {
        "24 points and turns": Effort(placements=len(points) + 3, reading=points.duration + turns.duration),
        "six positions, east, rates": Effort(placements=len(cube) + 3, reading=cube.duration + rates.duration),
    }


def handling_that_evens(point: float = 2 * MINUTE) -> float:
    """Time for one placement, s, at which both methods take equally long."""
    first, second = efforts(point).values()
    return (second.reading - first.reading) / (first.placements - second.placements)


@dataclass(frozen=True, kw_only=True)
class ScaleFactorError:
    """How well a method knows a gyro's scale factor.

    Attributes
    ----------
    noise : float
        Relative standard deviation from gyro, table and angle.
    at_full_rate : float
        Relative error of the rate that it gives at 200 deg/s, noise aside.
    """

    noise: float
    at_full_rate: float


def scale_factor_errors(
    *, turn_rate: float = 10 * DEG_PER_SECOND, turn_error: float = 10 * ARCSEC, rate_error: float = 5 * PPM
) -> dict[str, ScaleFactorError]:
    """Scale factor of the x gyro from turns by 360 deg and from the sequence of rates.

    Parameters
    ----------
    turn_rate : float, optional
        Rate of the turns, rad/s.
    turn_error : float, optional
        Standard deviation of the angle of a turn, rad.
    rate_error : float, optional
        Standard deviation of a rate of the table, relative to it.

    Returns
    -------
    dict
        For the turns, for a line through all rates, and for the line with asymmetry and cubic term.
    """
    unit = example_unit(random=False, shaped=True)
    full = max(placements.RATES)
    triad = unit.gyros.triad
    reading_at_full = unit.gyros.expected([full, 0, 0])[0] - triad.bias[0]

    turns = placements.full_turns(turn_rate)
    duration = turns.placements[0].duration
    observed = multiposition.turn_differences(_seen(unit, turns), turns)
    noise = np.sqrt(GYRO_NOISE.allan_variance(duration) / turn_rate**2 + (turn_error / (2 * np.pi)) ** 2) / np.sqrt(2)
    by_turns = observed.readings[0, 0] / observed.omega_ib_b[0, 0]
    found = {
        "turns by 360 deg": ScaleFactorError(
            noise=float(noise), at_full_rate=float(reading_at_full / (by_turns * full) - 1)
        )
    }
    sequence = placements.rate_sequence(axes="x")
    variance = GYRO_NOISE.allan_variance(sequence.placements[0].duration) * triad.scale_factor[0] ** 2
    covariance = np.tile(variance * np.eye(len(sequence)), (6, 1, 1))
    observed = replace(_seen(unit, sequence), covariance=covariance)
    for name, terms in (("rates, a line", ()), ("rates, with asymmetry and cubic term", ("asymmetry", "cubic"))):
        fit = rate_sequence.fit_scale_factor(observed, sequence, 0, terms=terms, rate_error=rate_error)
        model = fit.scale_factor * full + sum(
            fit.solution[term] * rate_sequence.SHAPES[term](np.array(full)) for term in terms
        )
        found[name] = ScaleFactorError(
            noise=fit.scale_factor_deviation / fit.scale_factor, at_full_rate=float(reading_at_full / model - 1)
        )
    return found


def _seen(unit: MeasurementUnit, schedule: Schedule) -> Observations:
    """Noise-free observations at the place of the examples, as it is believed to be."""
    return noise_free(unit, schedule, PLACE, PLACE)


@dataclass(frozen=True, kw_only=True)
class InstallationRun:
    """Errors of installation angles over many recordings.

    Attributes
    ----------
    rate : float
        Rate, rad/s.
    spread : float
        Root mean square error over recordings and angles, rad, where the rotation of the Earth is counted as input.
    without_earth : float
        The same where it is not, from a random azimuth, by half the differences of both directions.
    """

    rate: float
    spread: float
    without_earth: float


def installation_runs(seed: int = 1, runs: int = 8) -> list[InstallationRun]:
    """Installation errors at every rate of the list, from recordings with noise and pulses.

    All turns weigh alike, so that an angle is half the difference of a turn and its opposite: the Earth's vertical
    rate, if it is left out of the inputs, then goes into the residuals and not into the angles.

    Parameters
    ----------
    seed, runs : int, optional
        Seed and number of recordings at each rate.
    """
    rng = np.random.default_rng(seed)
    unit = example_unit()
    true = unit.gyros.triad.misalignment
    found = []
    for rate in (rate for rate in placements.RATES if rate > 0):
        sequence = placements.rate_sequence([rate, -rate])
        errors: dict[bool, list[NDArray[np.float64]]] = {True: [], False: []}
        for _ in range(runs):
            place = replace(PLACE, azimuth_error=float(rng.uniform(-0.49, 0.49)))
            recording = place.record(unit, sequence, rng, sample_rate=1.0)
            observed = replace(observations(recording, sequence, place), covariance=None)
            for counted in errors:
                used = observed if counted else rate_sequence.without_earth(observed, sequence)
                errors[counted].append(rate_sequence.installation(used, sequence, rate=rate).triad.misalignment - true)
        off = ~np.eye(3, dtype=bool)
        spreads = {key: float(np.sqrt(np.mean(np.square([e[off] for e in value])))) for key, value in errors.items()}
        found.append(InstallationRun(rate=rate, spread=spreads[True], without_earth=spreads[False]))
    return found


@dataclass(frozen=True, kw_only=True)
class EastBiasBudget:
    """What a bias from a position to the east is good to, rad/s.

    Attributes
    ----------
    noise : float
        Standard deviation from the random errors in the time of the reading.
    azimuth, level : float
        Error for the given error of azimuth and of level.
    """

    noise: float
    azimuth: float
    level: float


def east_bias_budget(error: float = ARCMIN, duration: float = 10 * MINUTE) -> EastBiasBudget:
    """Bias of a gyro whose axis is thought to point east, computed from the inputs of a plate that is not true.

    Parameters
    ----------
    error : float, optional
        Error of azimuth, and of level, rad.
    duration : float, optional
        Time of the reading, s.
    """
    east = placements.three_positions_east(duration).placements[0]
    true = PLACE.mean_inputs(east)[0][0]
    inputs = {
        name: replace(PLACE, **{name: error}).mean_inputs(east)[0][0] for name in ("azimuth_error", "level_north")
    }
    return EastBiasBudget(
        noise=float(np.sqrt(GYRO_NOISE.allan_variance(duration))),
        azimuth=float(abs(inputs["azimuth_error"] - true)),
        level=float(abs(inputs["level_north"] - true)),
    )


def gravity_of_a_tilt(error: float) -> float:
    """Relative error of an accelerometer's equivalent from a tilt of the plate, exactly ``1 - cos``."""
    force = replace(PLACE, level_east=error).mean_inputs(placements.six_positions().placements[4])[1]
    return float(1 - force[2] / PLACE.gravity)
