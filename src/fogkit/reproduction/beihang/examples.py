"""What the laboratory chapters compute besides the calibrations themselves: rooms, closed forms, covariances, trials.

The closed forms are reconstructions: in the slides the formulas were pictures and are lost. They follow from the words
around them: which numbers enter, and that they are a shorter way to the regression's result.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration import multiposition, rate_sequence
from fogkit.calibration.multiposition import LinearCalibration
from fogkit.calibration.rate_sequence import ScaleFactorFit
from fogkit.imu.triads import AXES, LinearTriad
from fogkit.imu.unit import MeasurementUnit
from fogkit.noise import RandomErrors, mean_covariance
from fogkit.reproduction.beihang.laboratory import (
    ACCELEROMETER_NOISE,
    ACCELEROMETER_PULSE,
    GYRO_NOISE,
    GYRO_PULSE,
    PLACE,
    calibrate_both,
    example_unit,
    noise_free,
)
from fogkit.stand import placements
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import Observations, observations
from fogkit.stand.placements import Schedule
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, MICRO_G, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

ROOM = replace(PLACE, azimuth_error=23 * DEG, level_east=60 * ARCSEC, level_north=-40 * ARCSEC)
"""The place with a plate off level and of unknown azimuth, as the 24 points are to stand it."""

PRINTED_POINTS = {
    "1.1": "UEN",
    "1.2": "USE",
    "1.3": "UWS",
    "1.4": "UNW",
    "2.1": "DES",
    "2.2": "DSW",
    "2.3": "DWN",
    "2.4": "DNE",
}
"""The eight of the 24 points that the slides print: where x, y and z point."""

NOISE = GYRO_NOISE, ACCELEROMETER_NOISE


def equivalents_of(unit: MeasurementUnit) -> NDArray[np.float64]:
    """Readings per unit of input of gyros and accelerometers, shape (6,)."""
    return np.concatenate([unit.gyros.triad.equivalents, unit.accelerometers.triad.equivalents])


def means_covariance(schedule: Schedule, random: RandomErrors, dt: float) -> NDArray[np.float64]:
    """Covariance of the mean errors if one placement follows straight after the other, shape (n, n), squared inputs.

    Parameters
    ----------
    schedule : Schedule
        What is done.
    random : RandomErrors
        Random errors of the sensor.
    dt : float
        Sample time, s.
    """
    stop = np.cumsum([placement.duration for placement in schedule.placements])
    return mean_covariance(random, np.append(0.0, stop[:-1]), stop, dt)


def each_for_itself(schedule: Schedule, random: RandomErrors) -> NDArray[np.float64]:
    """Covariance of the means if each were independent of the others, with its Allan variance: diagonal, (n, n)."""
    return np.diag(random.allan_variance([placement.duration for placement in schedule.placements]))


def weighted(observed: Observations, schedule: Schedule, unit: MeasurementUnit, dt: float | None = 0.1) -> Observations:
    """Observations with the covariance that follows from the random errors of the example.

    Parameters
    ----------
    observed : Observations
        One for each placement.
    schedule : Schedule
        What was done.
    unit : MeasurementUnit
        For the readings per unit of input.
    dt : float, optional
        Sample time, s. None: every mean for itself, with its Allan variance.
    """
    parts = [each_for_itself(schedule, r) if dt is None else means_covariance(schedule, r, dt) for r in NOISE]
    scale = equivalents_of(unit)[:, None, None]
    return replace(observed, covariance=np.repeat(parts, 3, axis=0) * scale**2)


def closed_accelerometers(positions: Observations, gravity: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Zero terms (3,) and components of the equivalents (3, 3) of accelerometers from F(6, 6), in closed form.

    Parameters
    ----------
    positions : Observations
        Means of the six positions, x up, x down, y up and so on.
    gravity : float
        m/s^2.

    Returns
    -------
    zero, matrix : ndarray
        The mean of the six readings, and half the difference of up and down over gravity.
    """
    readings = positions.readings[:, 3:]
    return readings.mean(axis=0), _half_differences(readings).T / gravity


def closed_equivalents(observed: Observations, turns: Schedule) -> NDArray[np.float64]:
    """Components of the equivalents of the gyros, shape (3, 3), from the pulses of turns both ways, in closed form.

    Parameters
    ----------
    observed : Observations
        Of the six turns: x plus, x minus, y plus and so on.
    turns : Schedule
        The turns.

    Returns
    -------
    ndarray, shape (3, 3)
        Pulses of the positive turn less those of the negative one, over both angles: readings per rad/s. Biases drop
        out if both last equally long.
    """
    durations = np.array([placement.duration for placement in turns.placements])
    angles = np.array([abs(placement.rate) for placement in turns.placements]) * durations
    pulses = observed.readings[:, :3] * durations[:, None]
    return ((pulses[::2] - pulses[1::2]) / (angles[::2] + angles[1::2])[:, None]).T


def closed_gyros(
    positions: Observations, matrix: NDArray[np.float64], laboratory: Laboratory
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Zero terms (3,) and acceleration sensitivities (3, 3) of gyros from F(6, 6), in closed form.

    Parameters
    ----------
    positions : Observations
        Means of the six positions, x up, x down, y up and so on.
    matrix : ndarray, shape (3, 3)
        Components of the equivalents, from the turns.
    laboratory : Laboratory
        For the vertical rotation of the Earth and gravity.

    Returns
    -------
    zero, sensitivity : ndarray
        The mean of the six readings; half the difference of up and down, less the Earth's part, over gravity.
    """
    readings = positions.readings[:, :3]
    differences = _half_differences(readings).T - matrix * laboratory.omega_ie_n[2]
    return readings.mean(axis=0), differences / laboratory.gravity


def _half_differences(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    return (readings[::2] - readings[1::2]) / 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Trials:
    """Errors of calibrations over their predicted standard deviations.

    Attributes
    ----------
    names : tuple of str
        The 24 coefficients, accelerometers first.
    normalised : ndarray, shape (runs, 24)
        Estimate less truth, over the standard deviation.
    chi_square : ndarray, shape (runs, 2)
        Of accelerometers and gyros.
    degrees_of_freedom : tuple of int
        Of both.
    """

    names: tuple[str, ...]
    normalised: NDArray[np.float64]
    chi_square: NDArray[np.float64]
    degrees_of_freedom: tuple[int, int]


def trials(runs: int, rng: np.random.Generator, *, dt: float = 0.1) -> dict[str, Trials]:
    """24 points and turns in `ROOM`, recorded again and again, with both ways to weight the means.

    Parameters
    ----------
    runs : int
        Recordings.
    rng : numpy.random.Generator
        Source of their noise.
    dt : float, optional
        Sample time, s.

    Returns
    -------
    dict of Trials
        "each for itself" and "together", from the same recordings.
    """
    unit, schedule = example_unit(), placements.twenty_four_points() + placements.full_turns()
    true = (unit.accelerometers.triad, unit.gyros.triad)
    truth = np.concatenate([np.column_stack([t.bias, t.matrix]).ravel() for t in true])
    found: dict[str, list[tuple[LinearCalibration, LinearCalibration]]] = {"each for itself": [], "together": []}
    for _ in range(checks.integer("runs", runs, minimum=1)):
        recording = ROOM.record(unit, schedule, rng, sample_rate=1 / dt)
        observed = observations(recording, schedule, PLACE)
        for (_, results), step in zip(found.items(), (None, dt), strict=True):
            results.append(calibrate_both(weighted(observed, schedule, unit, step), schedule))
    out = {}
    for way, results in found.items():
        frames = [[calibration.to_frame() for calibration in pair] for pair in results]
        estimates = np.array([np.concatenate([f.estimate for f in pair]) for pair in frames])
        deviations = np.array([np.concatenate([f.standard_deviation for f in pair]) for pair in frames])
        kinds = ("accelerometer", "gyro")
        out[way] = Trials(
            names=tuple(f"{kind} {name}" for kind, f in zip(kinds, frames[0], strict=True) for name in f.index),
            normalised=(estimates - truth) / deviations,
            chi_square=np.array([[calibration.chi_square for calibration in pair] for pair in results]),
            degrees_of_freedom=tuple(calibration.degrees_of_freedom for calibration in results[0]),
        )
    return out


def closed_form_of_unequal_turns(shorter: float) -> tuple[float, float]:
    """Relative errors of the x gyro's equivalent if the negative turn takes another time, without noise.

    Parameters
    ----------
    shorter : float
        Duration of the negative turn over that of the positive one.

    Returns
    -------
    closed, fit : float
        Of the closed form, and of the fit, which knows the share of the bias that is left.
    """
    unit, plan = example_unit(random=False), placements.full_turns()
    shorter = checks.positive("shorter", shorter)
    turns = Schedule(
        [replace(p, rate=p.rate / shorter, duration=p.duration * shorter) if p.rate < 0 else p for p in plan.placements]
    )
    true = unit.gyros.triad.matrix[0][0]
    closed = closed_equivalents(noise_free(unit, turns, PLACE, PLACE), turns)[0, 0]
    schedule = placements.twenty_four_points() + turns
    _, gyros = calibrate_both(noise_free(unit, schedule, PLACE, PLACE), schedule)
    return float(closed / true - 1), float(gyros.triad.matrix[0][0] / true - 1)


def record_sequence(
    unit: MeasurementUnit,
    rng: np.random.Generator,
    *,
    axes: str = "x",
    laboratory: Laboratory = PLACE,
    dt: float = 0.1,
) -> tuple[Schedule, Observations]:
    """The slides' sequence of 29 rates, recorded and averaged, with the covariance of the means.

    Parameters
    ----------
    unit : MeasurementUnit
        What is calibrated.
    rng : numpy.random.Generator
        Source of all random errors.
    axes : str, optional
        Axes to turn about.
    laboratory : Laboratory, optional
        Where it really happens; the inputs are those of `PLACE`.
    dt : float, optional
        Sample time, s.
    """
    sequence = placements.rate_sequence(axes=axes)
    recording = laboratory.record(unit, sequence, rng, sample_rate=1 / dt)
    return sequence, weighted(observations(recording, sequence, PLACE), sequence, unit, dt)


def fit_from(
    actual: Laboratory, unit: MeasurementUnit | None = None, terms: tuple[str, ...] = (), rate_scale: float = 1.0
) -> ScaleFactorFit:
    """Fit of the x gyro to the sequence of rates without noise, made in one place and read as in `PLACE`.

    Parameters
    ----------
    actual : Laboratory
        Where it happens.
    unit : MeasurementUnit, optional
        By default the example without random errors.
    terms : tuple of str, optional
        As in `fogkit.calibration.rate_sequence.fit_scale_factor`.
    rate_scale : float, optional
        What the table makes of a rate, over the commanded one.
    """
    unit = unit or example_unit(random=False)
    sequence = placements.rate_sequence(axes="x")
    made = Schedule([replace(p, rate=p.rate * rate_scale) for p in sequence.placements])
    observed = weighted(noise_free(unit, made, actual, PLACE), made, unit, None)
    believed = noise_free(unit, sequence, PLACE, PLACE)
    observed = replace(observed, omega_ib_b=believed.omega_ib_b, f_ib_b=believed.f_ib_b)
    return rate_sequence.fit_scale_factor(observed, sequence, 0, terms=terms)


def information_shares(rate_error: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What each rate of the sequence contributes to the scale factor of the x gyro.

    Parameters
    ----------
    rate_error : float
        Standard deviation of a rate of the table, relative to it.

    Returns
    -------
    rates, shares : ndarray, shape (15,)
        Sizes of the rates, rad/s, and shares of the information, both directions together, with the bias free.
    """
    sequence = placements.rate_sequence(axes="x")
    rates = np.array([placement.rate for placement in sequence.placements])
    variance = GYRO_NOISE.allan_variance(sequence.placements[0].duration) + (rate_error * rates) ** 2
    middle = np.average(rates, weights=1 / variance)
    information = (rates - middle) ** 2 / variance
    sizes = np.unique(np.abs(rates))
    shares = np.array([information[np.abs(rates) == size].sum() for size in sizes])
    return sizes, shares / shares.sum()


def repeated_heading() -> tuple[float, float]:
    """Bias errors of the gyros, rad/s, if one of the 24 points is taken at the heading of its neighbour, without noise.

    Returns
    -------
    all_right, one_wrong : float
        Largest bias error with the 24 headings as planned and with point 3.3 turned as 3.2.
    """
    unit, plan = example_unit(random=False), placements.twenty_four_points() + placements.full_turns()
    turned = {"3.3": next(p.axes for p in plan.placements if p.label == "3.2")}
    made = Schedule([replace(p, axes=turned.get(p.label, p.axes)) for p in plan.placements])
    errors = []
    for done in (plan, made):
        averaged = multiposition.average_positions(noise_free(unit, done, PLACE, PLACE), plan)
        believed = multiposition.average_positions(noise_free(unit, plan, PLACE, PLACE), plan)
        averaged = replace(averaged, omega_ib_b=believed.omega_ib_b, f_ib_b=believed.f_ib_b)
        turns = multiposition.turn_differences(noise_free(unit, plan, PLACE, PLACE), plan)
        gyros = multiposition.calibrate_gyros(averaged.joined(turns))
        errors.append(float(np.abs(gyros.triad.input_bias - unit.gyros.triad.input_bias).max()))
    return errors[0], errors[1]


def beside_truth(kind: str, calibration: LinearCalibration, true: LinearTriad) -> "DataFrame":
    """Bias, scale-factor error and misalignment, estimated and true, in the units of data sheets.

    Parameters
    ----------
    kind : {"gyro", "accelerometer"}
        For the units and the nominal scale factor, one reading per pulse.
    calibration : LinearCalibration
        The estimates.
    true : LinearTriad
        What was planted.

    Returns
    -------
    pandas.DataFrame
        Index ``coefficient`` with its unit; columns ``truth``, ``estimate``, ``deviation``, ``off by``: the error in
        standard deviations. Scale factors are relative to the nominal ones.
    """
    import pandas as pd

    pulse, bias_unit, bias_name = {
        "gyro": (GYRO_PULSE, DEG_PER_HOUR, "deg/h"),
        "accelerometer": (ACCELEROMETER_PULSE, MICRO_G, "µg"),
    }[checks.option("kind", kind, ("gyro", "accelerometer"))]
    found = calibration.to_frame("standard")
    values, units = [], []
    for name in found.index:
        term, _, axes = name.rpartition("_")
        j, k = AXES.index(axes[0]), AXES.index(axes[-1])
        table = {
            "bias": (true.input_bias[j], 0.0, bias_unit, bias_name),
            "scale_factor": (true.scale_factor[j] * pulse, 1.0, PPM, "ppm"),
            "misalignment": (true.misalignment[j, k], 0.0, ARCSEC, "arcsec"),
        }
        truth, nominal, factor, unit = table[term]
        scale = pulse if term == "scale_factor" else 1.0
        estimate = found.estimate[name] * scale
        deviation = found.standard_deviation[name] * scale
        values.append(
            [
                (truth - nominal) / factor,
                (estimate - nominal) / factor,
                deviation / factor,
                (estimate - truth) / deviation,
            ]
        )
        units.append(f"{kind} {term.replace('_', ' ')} {axes}, {unit}")
    columns = ["truth", "estimate", "deviation", "off by"]
    return pd.DataFrame(values, index=pd.Index(units, name="coefficient"), columns=columns)
