"""Calibration of a gyro triad in three stages on a rate table: biases, first and second approximation (volynskii).

The angle turned over whole turns is the reference, not the rate: the rotation of the Earth across the axis averages
out, and the readout errors at both ends count once. One code path serves the three constructions, because a plan says
about which nominal gyro axis the table turns.
"""

import warnings
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.triad import TriadCalibration
from fogkit.constants import EARTH_RATE
from fogkit.imu.errors import GyroTriad, misalignment_matrix, misalignments_from_matrix
from fogkit.stand.bench import BenchRecord
from fogkit.stand.plans import Plan
from fogkit.stand.table import RateTable

MINIMUM_ALONG = 0.999
"""Smallest cosine between a turning axis and the gyro axis it is for: errors of a unit, not of a plan, stay above."""


UNIT_RATIO = 10.0
"""Ratio of scale factors that gyros of one kind do not have, but units do: the smallest of the usual ones is 57."""


def calibrate(
    record: BenchRecord, *, approximation: int = 2, noise: tuple[GyroTriad, RateTable] | None = None
) -> TriadCalibration:
    """Parameters of a triad from a record with four bias positions and whole turns about each axis in both directions.

    Parameters
    ----------
    record : BenchRecord
        Readings and angles, of one or many runs.
    approximation : {1, 2}, optional
        2 takes the shortening of each gyro's own axis by its misalignment into account (volynskii eqs. (15) to (17)).
    noise : tuple of GyroTriad and RateTable, optional
        Noise levels of gyros and table, from which the covariance is propagated.

    Returns
    -------
    TriadCalibration
        Estimate, and its covariance if `noise` is given.

    Raises
    ------
    ValueError
        If positions or turns are missing that a parameter needs; the message names it. If the scale factors of the
        three gyros are of different sizes, as where one was recorded in another unit.

    Warns
    -----
    UserWarning
        If turns are not whole, with the error that the Earth's rotation then leaves in an angle.
    """
    if checks.integer("approximation", approximation, minimum=1) > 2:
        raise ValueError(f"`approximation` must be 1 or 2, got {approximation}")
    _require(record.plan)
    _warn_of_parts(record)
    estimate = _estimate(record, approximation)
    _check_units(estimate)
    if noise is None:
        return TriadCalibration(estimate=estimate)
    single = (
        record if record.readings.ndim == 2 else replace(record, readings=record.readings[0], turned=record.turned[0])
    )
    return TriadCalibration(estimate=estimate, covariance=_propagate(single, approximation, *noise))


def block_tilt(at_zero: TriadCalibration, at_half_turn: TriadCalibration) -> NDArray[np.float64]:
    """Tilt of a gyro block's axis against the table's inner axis, from calibrations at two angles of the block.

    A mounting error of the case is in it: the table cannot tell the two apart.

    Parameters
    ----------
    at_zero, at_half_turn : TriadCalibration
        Results with the block fixed at 0 and turned by half a turn. A tilt of the axis turns the apparent directions of
        the gyros one way in the first and the other way in the second.

    Returns
    -------
    ndarray, shape (..., 2)
        Small rotation about X_0 and Y_0 that brings the case's Z_0 onto the axis of the block, rad.
    """
    first, second = (misalignment_matrix(c.estimate[..., 9:]) for c in (at_zero, at_half_turn))
    turned = np.linalg.solve(0.5 * (first + second), 0.5 * (second - first))
    return np.stack([turned[..., 2, 1] - turned[..., 1, 2], turned[..., 0, 2] - turned[..., 2, 0]], axis=-1) / 2


def _estimate(record: BenchRecord, approximation: int) -> NDArray[np.float64]:
    plan = record.plan
    duration = np.array([s.duration for s in plan.segments])
    bias = record.readings[..., plan.positions, :].mean(axis=-2)  # stage 1: eq. (8) for all gyros at once
    integral = (record.readings - bias[..., None, :]) * duration[:, None]
    angle = record.turned + _earth_along(record) * duration  # about the turning axis, against inertial space
    # stage 2: turns of one direction are added up, which weights each by its angle
    share = np.zeros((*record.readings.shape[:-2], 2, 3, 3))  # direction, turned axis, gyro: reading per angle
    for s, sign in enumerate((1, -1)):
        for axis in range(3):
            chosen = plan.turns_about(axis, sign)
            share[..., s, axis, :] = integral[..., chosen, :].sum(axis=-2) / angle[..., chosen].sum(axis=-1)[..., None]
    own = np.diagonal(share, axis1=-2, axis2=-1)  # of each gyro about its own axis, per direction
    shortening = np.ones_like(own[..., 0, :])  # cosine of each gyro about its own axis: 1 by eq. (12)
    A_g = _directions(share, 1 / own, shortening)
    if approximation == 2:  # stage 3
        for _ in range(2):  # after the second time the cross terms change by less than rounding
            shortening = 1 - 0.5 * ((A_g**2).sum(axis=-1) - shortening**2)  # eq. (15)
            A_g = _directions(share, shortening[..., None, :] / own, shortening)
    scale = shortening[..., None, :] / own
    return np.concatenate([bias, scale[..., 0, :], scale[..., 1, :], misalignments_from_matrix(A_g)], axis=-1)


def _directions(share: NDArray, scale: NDArray, own: NDArray) -> NDArray[np.float64]:
    """Direction cosines, shape (..., 3, 3), rows of gyros: mean over both directions (eqs. (14), (17))."""
    # a gyro's cross input has the sign of cosine times turn: it is scaled by its own factor for that sign
    positive = share.mean(axis=-3) > 0
    same, other = scale[..., 0, :][..., None, :], scale[..., 1, :][..., None, :]
    forward = share[..., 0, :, :] * np.where(positive, same, other)
    backward = share[..., 1, :, :] * np.where(positive, other, same)
    cosines = np.swapaxes(0.5 * (forward + backward), -1, -2)
    index = np.arange(3)
    cosines[..., index, index] = own
    return cosines


def _earth_along(record: BenchRecord) -> NDArray[np.float64]:
    """Rotation of the Earth along the turning axis of an ideal table, rad/s, shape (n,); 0 for positions."""
    upward = EARTH_RATE * np.sin(record.latitude)
    north = EARTH_RATE * np.cos(record.latitude)
    along = []
    for s in record.plan.segments:
        if s.turning == "outer":
            along.append(upward)
        elif s.turning == "middle":  # the middle axis is level, turned from east by the outer one
            along.append(north * np.sin(s.outer))
        elif s.turning == "inner":
            along.append(upward * np.cos(s.middle) - north * np.sin(s.middle) * np.cos(s.outer))
        else:
            along.append(0.0)
    return np.array(along)


def _require(plan: Plan) -> None:
    """``ValueError`` that names the first parameter for which the plan has nothing, or has it wrong."""
    positions = [plan.segments[i] for i in plan.positions]
    if len(positions) not in (2, 4) or len({s.duration for s in positions}) != 1:
        raise ValueError(
            "`record.plan` must hold two or four bias positions of equal duration for `bias`, "
            f"got {len(positions)} of {sorted({s.duration for s in positions})} s"
        )
    table = RateTable(latitude=0.7)  # any place but a pole or the equator
    attitudes = table.C_0_n(*(np.array([getattr(s, name) for s in positions]) for name in ("outer", "middle", "inner")))
    left = np.einsum("nji,j->i", attitudes, table.omega_ie_n) / len(positions)
    if np.abs(left).max() > 1e-9 * EARTH_RATE:
        raise ValueError(
            "`record.plan` must hold bias positions in which the Earth's rotation cancels, got positions that leave "
            f"{left / EARTH_RATE} of it in the mean. Use `plans.four_positions`"
        )
    for i, s in enumerate(plan.segments):
        if s.turning is not None and s.gyro_axis is not None:
            along = plan.C_0_g1[i, s.gyro_axis] @ table.axis_in_case(s.turning, s.middle, s.inner)
            if along < MINIMUM_ALONG:
                raise ValueError(
                    f"`record.plan` must turn about the axis of the gyro that a segment names, got segment {i + 1} "
                    f"({s.label}), where it is {np.rad2deg(np.arccos(along)):.4g} deg off. Use `plans.placement`"
                )
    for axis, name in enumerate("xyz"):
        for sign, scale in ((1, f"scale_positive_{name}"), (-1, f"scale_negative_{name}")):
            if not plan.turns_about(axis, sign):
                raise ValueError(
                    f"`record.plan` must hold a turn about {name} in the direction {sign:+d} for `{scale}`"
                )


def _check_units(estimate: NDArray) -> None:
    """``ValueError`` where the scale factor of one gyro is of another order of magnitude: mixed units."""
    scale = np.abs(estimate[..., 3:9]).reshape(-1, 6)[0]
    odd = int(np.argmax(np.abs(np.log(scale / np.median(scale)))))
    ratio = scale[odd] / np.median(scale)
    if not 1 / UNIT_RATIO < ratio < UNIT_RATIO:
        raise ValueError(
            f"`record.readings` must be in one unit: the scale factor of gyro {'xyz'[odd % 3]} is {ratio:.4g} times "
            "the median of all. Convert its readings, or turn the gyro whose readings these are"
        )


def _warn_of_parts(record: BenchRecord) -> None:
    """Warn of turns that are not whole, with the angle that the Earth's rotation leaves."""
    parts = [s for s in record.plan.segments if not s.is_whole]
    if not parts:
        return
    # across the axis the Earth turns with at most its full rate; of its sinusoid the part of a turn leaves one chord
    worst = max(2 * abs(np.sin(np.pi * s.turns)) * EARTH_RATE / (s.rate**2 * s.duration) for s in parts)
    warnings.warn(
        f"{len(parts)} turns are not whole ({parts[0].label}: {parts[0].turns:.6g} turns): the rotation of the Earth "
        f"leaves up to {worst:.3g} rad in the angles. Use `bench_fit.fit`, which models it",
        UserWarning,
        stacklevel=3,
    )


def _propagate(record: BenchRecord, approximation: int, triad: GyroTriad, table: RateTable) -> NDArray[np.float64]:
    """Covariance of the estimate: the derivative with respect to every number that was written down, by differences."""
    readings, angles = deviations(record.plan, triad, table)
    n = angles.size
    columns = []
    for deviation, name in ((readings, "readings"), (angles[:, None], "turned")):
        values = getattr(record, name).reshape(n, -1)
        for i, j in np.argwhere(deviation > 0):
            shifted = []
            for sign in (1, -1):
                moved = values.copy()
                moved[i, j] += sign * deviation[i, j]
                shifted.append(
                    _estimate(replace(record, **{name: moved.reshape(getattr(record, name).shape)}), approximation)
                )
            columns.append((shifted[0] - shifted[1]) / 2)
    return np.einsum("ki,kj->ij", columns, columns) if columns else np.zeros((15, 15))


def deviations(plan: Plan, triad: GyroTriad, table: RateTable) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Standard deviations of what is written down on a bench.

    Parameters
    ----------
    plan : Plan
        The plan.
    triad, table
        Noise levels of gyros and table.

    Returns
    -------
    readings : ndarray, shape (n, 3)
        Of the mean readings, in their units: angle random walk and bias instability.
    turned : ndarray, shape (n,)
        Of the angles, rad: readout and latch time at both ends; 0 for positions.
    """
    duration = np.array([s.duration for s in plan.segments])
    rate = np.array([s.rate for s in plan.segments])
    scale = 0.5 * (np.array(triad.scale_positive) + np.array(triad.scale_negative))
    rates = np.sqrt(triad.angle_random_walk**2 / duration + triad.bias_instability**2)
    angle = np.sqrt(2 * (table.readout_noise**2 + (rate * table.latch_time_error) ** 2))
    return rates[:, None] / scale, np.where(rate == 0, 0.0, angle)
