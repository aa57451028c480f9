"""Simulations behind the chapters on requirements and on the budget: gyros by samples, a ship, a warming bench."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit.calibration import requirements
from fogkit.imu.constructions import Construction
from fogkit.imu.errors import GyroTriad
from fogkit.reproduction.volynskii import instruments as paper
from fogkit.reproduction.volynskii import simulation
from fogkit.rotation import dcm_from_heading_pitch_roll, dcm_from_rotvec, rotvec_from_dcm, small_angle_between
from fogkit.stand import bench, plans
from fogkit.stand.plans import Plan
from fogkit.stand.table import RateTable
from fogkit.units import ARCSEC, DEG_PER_HOUR, DEG_PER_SECOND, REVOLUTION

if TYPE_CHECKING:
    import pandas as pd

TEST_TURNS = {1: 1, 4: 1, 9: 3, 18: 6, 36: 12}
"""Whole turns at each rate, deg/s, of a test that takes half an hour or less in both directions: the paper has the ends
of the range and the duration, not the rates."""


def sampled_rates(triad: GyroTriad, omega_ib_b: ArrayLike, believed: GyroTriad | None = None) -> NDArray[np.float64]:
    """Rates that a user computes from the readings of a triad, sample by sample.

    Parameters
    ----------
    triad : GyroTriad
        The gyros; their noise and drift are left out.
    omega_ib_b : array_like, shape (..., 3)
        True rate, rad/s.
    believed : GyroTriad, optional
        The calibration that is used; ideal gyros if not given.

    Returns
    -------
    ndarray, shape (..., 3)
        Rates, rad/s; less `omega_ib_b` they are the errors.
    """
    believed = GyroTriad() if believed is None else believed
    inputs = np.asarray(omega_ib_b, float) @ triad.A_g.T
    signals = inputs / np.where(inputs > 0, triad.scale_positive, triad.scale_negative)  # readings less the bias
    signals = signals + np.array(triad.bias) - np.array(believed.bias)
    used = signals * np.where(signals > 0, believed.scale_positive, believed.scale_negative)
    return used @ np.linalg.inv(believed.A_g).T


def roll_and_pitch(
    roll: float, pitch: float, period: float, phase: float, samples: int = 1000
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Attitude and rate of a ship that rolls and pitches with one period.

    Parameters
    ----------
    roll, pitch : float
        Amplitudes, rad.
    period : float
        Period, s.
    phase : float
        By which the pitch is ahead of the roll, rad; 0 is rocking about one slanting axis.
    samples : int, optional
        Steps of one period.

    Returns
    -------
    C_b_n : ndarray, shape (samples + 1, 3, 3)
        Attitude.
    omega_nb_b : ndarray, shape (samples, 3)
        Constant rate of each step that turns one attitude into the next, rad/s; the Earth rate is left out.
    """
    angle = 2 * np.pi * np.arange(samples + 1) / samples
    C_b_n = dcm_from_heading_pitch_roll(0 * angle, pitch * np.sin(angle + phase), roll * np.sin(angle))
    steps = np.swapaxes(C_b_n[:-1], -1, -2) @ C_b_n[1:]
    return C_b_n, rotvec_from_dcm(steps) * samples / period


def circles(rate: float, turns: float, samples: int = 1000) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Attitude and rate of a level ship in a steady turn.

    Parameters
    ----------
    rate : float
        Rate of the turn, rad/s, positive to port.
    turns : float
        Full circles.
    samples : int, optional
        Steps.

    Returns
    -------
    C_b_n, omega_nb_b
        As in `roll_and_pitch`.
    """
    heading = -np.sign(rate) * 2 * np.pi * turns * np.arange(samples + 1) / samples
    C_b_n = dcm_from_heading_pitch_roll(heading, 0 * heading, 0 * heading)
    return C_b_n, np.broadcast_to([0.0, 0.0, rate], (samples, 3))


def attitude_errors(
    C_b_n: NDArray, omega_nb_b: NDArray, duration: float, triad: GyroTriad, believed: GyroTriad | None = None
) -> NDArray[np.float64]:
    """Error of the attitude that is computed from a triad's readings during a motion, by brute force.

    Parameters
    ----------
    C_b_n, omega_nb_b
        As `roll_and_pitch` and `circles` give them.
    duration : float
        Duration of the motion, s.
    triad, believed
        As in `sampled_rates`.

    Returns
    -------
    ndarray, shape (n + 1, 3)
        Computed less true attitude along east, north, up, rad; the last one over `duration` is the mean drift.
    """
    steps = dcm_from_rotvec(sampled_rates(triad, omega_nb_b, believed) * duration / len(omega_nb_b))
    computed = [C_b_n[0]]
    for step in steps:
        computed.append(computed[-1] @ step)
    return -small_angle_between(np.array(computed), C_b_n)


def locked_drift(roll: float, pitch: float, period: float, phase: ArrayLike) -> NDArray[np.float64]:
    """Mean rate about the vertical of the cone that roll and pitch of one period make, small angles.

    Parameters
    ----------
    roll, pitch, period, phase
        As in `roll_and_pitch`; phases of any shape.

    Returns
    -------
    ndarray, shape (...,)
        ``pi / period * roll * pitch * sin(phase)``, rad/s: times a scale factor error that all gyros share it is the
        drift in heading, times a lean of the vertical gyro that of the level.
    """
    return np.pi / period * roll * pitch * np.sin(phase)


def example_bench(*, shared_bias: bool, noise_factor: float = 1.0) -> tuple[Plan, GyroTriad, RateTable]:
    """Plan, gyros and table with the errors of the paper's example for (22), 36 whole turns each way.

    Parameters
    ----------
    shared_bias : bool
        Whether the bias error of 0.01 arcsec/s is that of the bias positions, which all turns share, or is drawn anew
        for every reading.
    noise_factor : float, optional
        One of `budget.NOISE_FACTORS`.

    Returns
    -------
    tuple of Plan, GyroTriad and RateTable
        For `fogkit.stand.bench.run`. The bias error that is shared comes from the angle random walk of four positions
        too short for it; the one drawn anew is a bias instability, and the mean of four long positions keeps half of
        it.
    """
    walk = paper.EXAMPLE_NOISE * np.sqrt(noise_factor)
    instability = 0.0 if shared_bias else paper.EXAMPLE_BIAS_ERROR / np.sqrt(1 + 1 / 4)
    position = (walk / paper.EXAMPLE_BIAS_ERROR) ** 2 / 4 if shared_bias else paper.BIAS_DURATION
    rate = paper.TEST_RATES[1]
    count = round(rate * paper.EXAMPLE_DURATION / REVOLUTION)
    plan = plans.three_stage(Construction(name="plain"), bias_duration=position, rates=(rate, -rate), count=count)
    triad = GyroTriad(angle_random_walk=walk, bias_instability=instability)
    return plan, triad, RateTable(latitude=simulation.ASSUMED_LATITUDE, readout_noise=paper.EXAMPLE_READOUT)


def half_hour_plan() -> Plan:
    """Turns about x of `TEST_TURNS`, each rate in both directions, slowest first."""
    segments = []
    for rate, count in TEST_TURNS.items():
        both = (rate * DEG_PER_SECOND, -rate * DEG_PER_SECOND)
        segments += plans.turns(Construction(name="plain"), both, count=count)[:2]
    return Plan(Construction(name="plain"), segments)


def warming_scale_factors(
    *,
    scale_per_kelvin: float = 0.0,
    bias_per_kelvin: float = 0.0,
    bias_error: float = 0.0,
    readout: float = 0.0,
    rng: np.random.Generator | None = None,
) -> pd.DataFrame:
    """Relative errors of scale factors found at several rates, while the temperature rises by 1 K.

    Parameters
    ----------
    scale_per_kelvin : float, optional
        Temperature coefficient of the scale factor, relative, 1/K.
    bias_per_kelvin : float, optional
        Temperature coefficient of the bias, rad/s/K; the bias is taken off as it was at the start.
    bias_error : float, optional
        Constant error of the bias that is taken off, rad/s.
    readout : float, optional
        Standard deviation of one angle reading, rad; needs `rng`.
    rng : numpy.random.Generator, optional
        Source of the readout errors.

    Returns
    -------
    pandas.DataFrame
        Index ``rate``, deg/s; columns ``positive`` and ``negative``: (13), with a true scale factor of 1 at the start.
    """
    import pandas as pd

    plan = half_hour_plan()
    per_second = paper.TEST_TEMPERATURE_CHANGE / plan.duration
    triad = GyroTriad(bias=(bias_error, 0, 0), bias_drift=(bias_per_kelvin * per_second, 0, 0))
    table = RateTable(latitude=simulation.ASSUMED_LATITUDE, readout_noise=readout)
    found, elapsed = [], 0.0
    for i, segment in enumerate(plan.segments):
        factor = 1 + scale_per_kelvin * per_second * (elapsed + segment.duration / 2)
        warm = replace(triad, scale_positive=(factor,) * 3, scale_negative=(factor,) * 3)
        record = bench.run(plan, warm, table, rng=rng)
        found.append(record.turned[i] / (record.readings[i, 0] * segment.duration) - 1)
        elapsed += segment.duration
    index = pd.Index(TEST_TURNS, name="rate")
    return pd.DataFrame(np.reshape(found, (-1, 2)), index=index, columns=["positive", "negative"])


def spread(found: pd.DataFrame) -> float:
    """Largest less smallest scale factor over the rates, in the direction where that is larger."""
    return float((found.max() - found.min()).max())


def drifts_of_the_tables() -> pd.DataFrame:
    """Drift that each spread and asymmetry of Tables 1 to 3 makes at sea, if it is an error of the calibration.

    Returns
    -------
    pandas.DataFrame
        Columns ``group``, ``printed`` (with its unit), ``drift`` (deg/h): the spread of a bias as it stands, an
        asymmetry under the paper's rocking, scale factors (spread over mean) and angles in its fastest turn; and what
        is the same in all readings, mounting and non-orthogonality of the table.
    """
    import pandas as pd

    turn = paper.TURN_RATES[1]
    rows = {}
    for axis, cell in paper.TABLE_1.items():
        rows[f"bias {axis}"] = ("Table 1", f"{cell['spread']} deg/h", cell["spread"] * DEG_PER_HOUR)
    drifts = simulation.rocking_drifts_of_table_2()
    for axis, value in simulation.asymmetries().items():
        rows[f"asymmetry {axis}"] = ("Table 2, means", f"{value:.1e}", drifts[axis])
    for name, value in simulation.relative_spreads().items():
        drift = requirements.drift_from_scale_error(value, turn)
        rows[f"scale {name}"] = ("Table 2, spreads", f"{value:.1e}", drift)
    angles = {name: ("Table 3", cell["spread"] * ARCSEC) for name, cell in paper.TABLE_3.items()}
    angles["mounting"] = ("not in the tables", paper.SMALL_ANGLES[1])
    angles["table axes"] = ("not in the tables", paper.TABLE_NONORTHOGONALITY)
    for name, (group, angle) in angles.items():
        drift = requirements.drift_from_misalignment(angle, turn)
        label = f"angle {name}" if group == "Table 3" else name
        rows[label] = (group, f"{angle / ARCSEC:.1f} arcsec", drift)
    frame = pd.DataFrame(rows, index=["group", "printed", "drift"]).T
    return frame.assign(drift=frame.drift.astype(float) / DEG_PER_HOUR)
