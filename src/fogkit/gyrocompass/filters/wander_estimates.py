"""What the filter with the Earth's axis for a state says: its own states, and from them heading, trim and roll."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit.gyrocompass.filters.runs import FilterRun, wrapped
from fogkit.gyrocompass.frames import hull_attitude
from fogkit.gyrocompass.mechanisation import EARTH_RADIUS, TRIM_MARGIN
from fogkit.gyrocompass.motions import Motion
from fogkit.rotation import small_angle_between

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class WanderRun(FilterRun):
    """Estimates over time in the quantities of the thesis, and in those of the filter.

    Standard deviations of the former are to first order: heading's are right while they are some degrees.

    Attributes
    ----------
    C_h_w : ndarray, shape (k, 3, 3)
        Attitude of the hull against w.
    state : ndarray, shape (k, 14)
        Velocity north, up, east; latitude, longitude, height; the Earth's axis 1, 2; biases; scale factors.
    wander_covariance : ndarray, shape (k, 17, 17)
        Of the errors `fogkit.gyrocompass.filters.wander_model.WANDER_STATES`.
    """

    C_h_w: Array
    state: Array
    wander_covariance: Array

    def wander_errors(self, motion: Motion, bias: ArrayLike = 0.0, scale_factor: ArrayLike = 0.0) -> Array:
        """Errors of the filter's own states, shape (k, 17), in the order of `WANDER_STATES`.

        Parameters
        ----------
        motion : Motion
            True motion.
        bias, scale_factor : array_like, shape (3,) or (k, 3), optional
            True biases, rad/s, and scale factors.
        """
        rows = np.rint(self.time / motion.dt).astype(int)
        C_h_g, truth = hull_attitude(*motion.states[rows, :3].T), motion.states[rows, 3:9]
        # true azimuth of w against north: what heading was wrong by at the start, and what meridians converged since
        turning = motion.states[:, 5] * np.tan(motion.states[:, 6]) / (EARTH_RADIUS + motion.states[:, 8])
        steps = np.concatenate([[0.0], np.cumsum(0.5 * (turning[1:] + turning[:-1])) * motion.dt])
        azimuth = self._true_azimuth(hull_attitude(*motion.states[0, :3])) + steps[rows]
        C_w_g = hull_attitude(azimuth, 0.0, 0.0)
        C_h_w = C_w_g.swapaxes(1, 2) @ C_h_g
        axis = np.cos(truth[:, 3]) * np.array([np.cos(azimuth), -np.sin(azimuth)])
        errors = np.zeros((len(rows), 17))
        errors[:, :3] = -small_angle_between(self.C_h_w, C_h_w)
        errors[:, 3:9] = self.state[:, :6] - truth
        errors[:, 7] = wrapped(errors[:, 7])
        errors[:, 9:11] = self.state[:, 6:8] - axis.T
        errors[:, 11:14], errors[:, 14:] = bias - self.state[:, 8:11], scale_factor - self.state[:, 11:]
        return errors

    def _true_azimuth(self, C_h_g: Array) -> float:
        """Azimuth of w at the start, rad: that from which the computed attitude there differs by tilts only."""
        azimuth = 0.0
        for _ in range(30):  # a turn about up changes the third part of a turn vector by nearly itself
            wrong = small_angle_between(self.C_h_w[0], hull_attitude(azimuth, 0.0, 0.0).T @ C_h_g)[1]
            azimuth -= wrong
            if abs(wrong) < 1e-15:
                break
        return azimuth


def wander_result(time: Array, C: Array, s: Array, P: Array, innovations: tuple) -> WanderRun:
    """Run in the quantities of the thesis, from that in the filter's."""
    north = _north(s, P)
    angles, T = _angles(C, s, *north)
    estimate = np.hstack([angles, s[:, :6], s[:, 8:]])
    steepest = np.abs(angles[:, 1]).max()
    if steepest > np.pi / 2 - TRIM_MARGIN:
        warnings.warn(
            f"trim comes within {np.pi / 2 - steepest:.2g} rad of the vertical, where heading and roll are not defined "
            "apart: use `C_h_w`",
            UserWarning,
            stacklevel=4,
        )
    fix_time, nis, counts = innovations
    return WanderRun(
        time=time,
        estimate=estimate,
        covariance=T @ P @ T.swapaxes(1, 2),
        fix_time=fix_time,
        nis=nis,
        fix_count=counts,
        C_h_w=C,
        state=s,
        wander_covariance=P,
    )


def _north(s: Array, P: Array) -> tuple[Array, Array]:
    """Direction of north in w, shape (k, 2), and the length by which an error of the axis turns it, (k,).

    The length is that of the axis, or its uncertainty where that is larger: then nothing is known of north, and its
    standard deviation comes out as 0.7 rad at most instead of without bound.
    """
    axis = s[:, 6:8]
    found = np.linalg.norm(axis, axis=1)
    north = np.where(found[:, np.newaxis] > 0, axis / np.where(found > 0, found, 1.0)[:, np.newaxis], [1.0, 0.0])
    return north, np.maximum(found, np.sqrt(P[:, 9, 9] + P[:, 10, 10]))


def _angles(C: Array, s: Array, north: Array, length: Array) -> tuple[Array, Array]:
    """Heading, trim and roll, shape (k, 3); derivatives of the errors of all 15 by the filter's, (k, 15, 17)."""
    n_1, n_2 = north.T
    ahead, trim_sine, abeam = C[:, 0, 0], C[:, 1, 0], C[:, 2, 0]
    square = np.maximum(ahead**2 + abeam**2, 1e-24)
    heading = wrapped(np.arctan2(abeam, ahead) + np.arctan2(-n_2, n_1))
    trim = np.arctan2(trim_sine, np.sqrt(square))
    roll = np.arctan2(-C[:, 1, 2], C[:, 1, 1])
    T = np.zeros((len(s), 15, 17))
    T[:, 0, 0], T[:, 0, 1], T[:, 0, 2] = trim_sine * ahead / square, -1.0, trim_sine * abeam / square
    T[:, 0, 9], T[:, 0, 10] = n_2 / length, -n_1 / length
    T[:, 1, 0], T[:, 1, 2] = -abeam / np.sqrt(square), ahead / np.sqrt(square)
    T[:, 2, 0], T[:, 2, 2] = ahead / square, abeam / square
    for row in range(3, 9):
        T[:, row, row] = 1.0
    for row in range(9, 15):  # estimate less truth: the negative of what the gyros have left
        T[:, row, row + 2] = -1.0
    return np.stack([heading, trim, roll], axis=-1), T
