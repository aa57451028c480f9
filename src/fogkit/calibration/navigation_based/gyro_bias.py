"""Biases of the gyros, from a long dwell, half a turn about the vertical, and another long dwell.

The paper's (29)-(31) look at what a wrong bias does to a navigation: the velocities bend, the heading drifts. The bias
of a level gyro has the same sign in the unit before and after the half turn, and the opposite one in space, so what the
Earth's rotation adds drops out of the differences (29), (30). In the sum (31) it does not: a start that is tilted about
east by e sees ``e Omega cos(latitude)`` as drift of the heading, 4e-8 rad/s of 1e-3 rad. `estimate_gyro_biases` with
``method="rates"`` has no such error: biases, tilt and heading are found together from the mean readings of both dwells.

References
----------
.. [1] B. V. Klimkovich, Precise calibration of strapdown INS using low-accuracy turntables, Gyroscopy and Navigation
   (in Russian), vol. 30, no. 4 (119), 2022, pp. 54-70.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks, earth
from fogkit.calibration.navigation_based import plausibility
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.processing import gravity_vector, levelled
from fogkit.calibration.navigation_based.recordings import Recording, recordings_of
from fogkit.calibration.navigation_based.slopes import SlopeFit
from fogkit.estimation import Solution, linear
from fogkit.navigation import State, Trajectory, integrate_arrays
from fogkit.results import FrozenArrays
from fogkit.rotation import dcm_from_rotvec, skew
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

BIASES = ("b_g_1", "b_g_2", "b_g_3")
STATES = (*BIASES, "tilt_east", "tilt_north", "turn_up")
"""Unknowns of the method by rates: errors of the biases, rad/s, and a rotation of the start about east, north, up."""

BLOCK = 1.0
"""Duration, s, of the blocks whose scatter gives the standard deviation of a mean reading."""

ACCELEROMETER_BIAS = 1e-4
"""What the calibrated accelerometers may still be wrong by, m/s^2: the standard deviation in table 1 of [1]_."""

_BEND = (10 / 7, 120 / 7)
_LINE = 6 / 5
"""What a parabola through the velocity, and a line through the heading, make of the variance of a mean rate, and the
former of that of a mean specific force over ``(g T)^2``. Residuals of both see next to nothing of random walks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GyroBiases(FrozenArrays):
    """Result of `estimate_gyro_biases`.

    Attributes
    ----------
    compensation : Compensation
        The given one with gyro biases corrected.
    bias : ndarray, shape (3,)
        What the given compensation had too much, rad/s.
    standard_deviation : ndarray, shape (3,)
        Standard deviations, rad/s, from the scatter of the readings in blocks of a second, as if they were white: angle
        and velocity random walk are in it, bias instability is not.
    log : DataFrame
        A row for each iteration: the estimate so far ``b_g_1, b_g_2, b_g_3``, rad/s (fig. 6 of the paper), and
        ``largest_correction``.
    C_b_n : ndarray, shape (3, 3)
        Attitude in the first dwell: by rates free of the biases, else the one that was started from.
    solution : Solution or None
        Least squares of the last iteration, by rates.
    """

    compensation: Compensation
    bias: Array
    standard_deviation: Array
    log: "DataFrame"
    C_b_n: Array
    solution: Solution | None = None


def estimate_gyro_biases(
    recording: "DataFrame",
    test: TurnTest,
    compensation: Compensation,
    latitude: float,
    *,
    altitude: float = 0.0,
    gravity: float | ArrayLike | None = None,
    method: str = "slopes",
    initial_attitude: str | ArrayLike = "levelled",
    azimuth: float = 0.0,
    iterations: int = 4,
    settle: float = 0.0,
    dwells: str = "plan",
    accelerometer_bias_deviation: float = ACCELEROMETER_BIAS,
) -> GyroBiases:
    """Gyro biases from one recording of dwell, half a turn about the vertical, dwell.

    Parameters
    ----------
    recording : DataFrame
        Raw increments, as for `calibrate`.
    test : TurnTest
        What was commanded, `fogkit.stand.turn_tests.bias_test` for the paper's: an axis of the unit upright, half a
        turn about it.
    compensation : Compensation
        Calibrated matrices and accelerometer biases.
    latitude, altitude, gravity
        As for `calibrate`.
    method : {"slopes", "rates"}, optional
        (29)-(31), or biases, tilt and heading from the mean readings of both dwells.
    initial_attitude : {"levelled", "model"} or array_like, shape (3, 3), optional
        Attitude at the start; for ``"rates"`` only where the iteration begins.
    azimuth : float, optional
        Angle, rad, clockwise, by which the table stands turned from what the plan says.
    iterations : int, optional
        Number of iterations.
    settle, dwells
        As for `calibrate`.
    accelerometer_bias_deviation : float, optional
        Standard deviation of what is left of accelerometer biases, m/s^2, for the weight of the tilt in ``"rates"``.

    Returns
    -------
    GyroBiases

    Raises
    ------
    ValueError
        If the test is no half turn about an axis that stands upright, or the recording is not of that test: wrong
        units, a dwell in motion, another face up or another turn, as `plausibility` says.

    Warns
    -----
    UserWarning
        If the mean rates in the halves of a dwell differ by more than noise.
    """
    checks.option("method", method, ("slopes", "rates"))
    fix = "A result of `calibrate` has it as `.compensation`."
    checks.instance("compensation", compensation, Compensation, fix=fix)
    _require_half_turn(test)
    (prepared,) = recordings_of([recording], [test], settle=settle, dwells=dwells)
    latitude = float(earth.checked_latitude(latitude, "latitude", earth.POLE_MARGIN))
    down = gravity_vector(gravity, latitude, altitude)
    _require_plausible(prepared, compensation, float(np.linalg.norm(down)))
    C_b_n = _start(initial_attitude, prepared, compensation, azimuth, down)
    run = _Run(prepared, latitude, altitude, down, accelerometer_bias_deviation)
    found, log, solution = compensation, [], None
    for _ in range(checks.integer("iterations", iterations, minimum=1)):
        trajectory = run.navigate(found, C_b_n)
        if method == "slopes":
            errors, deviations = run.by_slopes(trajectory, found, C_b_n)
        else:
            solution, C_b_n = run.by_rates(trajectory, found, C_b_n)
            errors, deviations = solution.estimate[:3], solution.standard_deviation[:3]
        found = found.corrected(dict(zip(BIASES, errors.tolist(), strict=True)))
        so_far = compensation.gyro_bias - found.gyro_bias
        log.append(dict(zip(BIASES, so_far.tolist(), strict=True)) | {"largest_correction": np.abs(errors).max()})
    return GyroBiases(
        compensation=found,
        bias=so_far,
        standard_deviation=deviations,
        log=_frame(log),
        C_b_n=C_b_n,
        solution=solution,
    )


@dataclass(frozen=True, eq=False)
class _Run:
    """The recording and its place."""

    recording: Recording
    latitude: float
    altitude: float
    gravity: Array
    accelerometer_bias_deviation: float

    def navigate(self, compensation: Compensation, C_b_n: Array) -> Trajectory:
        recording = self.recording
        gyro, accel = _compensated(recording, compensation)
        return integrate_arrays(
            gyro,
            accel,
            recording.dt,
            State(lat=self.latitude, alt=self.altitude, C_b_n=C_b_n),
            gravity=self.gravity,
            velocity_reset=[recording.dwells[1][0] * recording.dt],
            position_fixed=True,
        )

    def by_slopes(self, trajectory: Trajectory, compensation: Compensation, C_b_n: Array) -> tuple[Array, Array]:
        """(29)-(31), for any axis upright and any heading of the others, and standard deviations."""
        bends, drifts, variances = [], [], np.zeros(3)
        upright, g = int(np.argmax(np.abs(C_b_n[2]))), float(np.linalg.norm(self.gravity))
        for first, last in self.recording.dwells:
            nodes = slice(first + 1, last + 1)
            bends.append(SlopeFit.of(trajectory.time[nodes], 2, derivative=2)(trajectory.v_eb_n[nodes, :2])[0])
            yaw = _yaw(trajectory, nodes, upright)
            drifts.append(SlopeFit.of(trajectory.time[nodes], 1)(yaw[:, np.newaxis])[0][0])
            variances += self._variances(compensation, trajectory.C_b_n[last], slice(first, last)) / 4
        change, drift = (bends[1] - bends[0]) / (2 * g), -0.5 * (drifts[0] + drifts[1])
        # before the half turn: the bias along east bends the velocity north by -g, that along north the one east by +g
        in_n = np.array([change[1], -change[0], drift])
        return C_b_n.T @ in_n, np.sqrt((C_b_n.T**2) @ variances)

    def _variances(self, compensation: Compensation, C_b_n: Array, dwell: slice) -> Array:
        """Variances, (rad/s)^2, of the rates about east, north, up that bends and line of one dwell tell."""
        gyro, accel = _compensated(self.recording, compensation)
        (_, rate), (_, force) = (_mean(increments[dwell], self.recording.dt) for increments in (gyro, accel))
        rates, forces = (C_b_n**2) @ rate**2, (C_b_n**2) @ force**2
        reach = np.linalg.norm(self.gravity) * self.recording.dt * (dwell.stop - dwell.start)
        level = _BEND[0] * rates[:2] + _BEND[1] * forces[1::-1] / reach**2  # a rate about east bends the way north
        return np.append(level, _LINE * rates[2])

    def by_rates(self, trajectory: Trajectory, compensation: Compensation, C_b_n: Array) -> tuple[Solution, Array]:
        """Least squares for biases and a small rotation of the start, from the means of both dwells."""
        recording, g = self.recording, float(np.linalg.norm(self.gravity))
        nodes = trajectory.C_b_n[[recording.dwells[0][1], recording.dwells[1][0]]]
        # at rest the unit stands as at the start; how far it turned is what was navigated between the dwells alone
        attitudes = C_b_n, C_b_n @ nodes[0].T @ nodes[1]
        omega, up = earth.earth_rate_n(self.latitude), -self.gravity / g
        rows, values, deviations = [], [], []
        gyro, accel = _compensated(recording, compensation)
        for (first, last), C in zip(recording.dwells, attitudes, strict=True):
            rate, rate_deviation = _mean(gyro[first:last], recording.dt)
            force, force_deviation = _mean(accel[first:last], recording.dt)
            rows.append(np.hstack([np.eye(3), C.T @ skew(omega)]))
            values.append(rate - C.T @ omega)
            deviations.append(rate_deviation)
            rows.append(np.hstack([np.zeros((2, 3)), skew(up)[:2]]))  # C f is g (up - rotation x up)
            values.append(C[:2] @ force / g - up[:2])
            tilt = np.sqrt((C[:2] ** 2) @ force_deviation**2 + self.accelerometer_bias_deviation**2) / g
            deviations.append(tilt)
        deviation = np.maximum(np.concatenate(deviations), 1e-14)  # without noise: rounding
        solution = linear(np.vstack(rows), np.concatenate(values), standard_deviation=deviation, names=STATES)
        return solution, dcm_from_rotvec(solution.estimate[3:].copy()) @ C_b_n


def _compensated(recording: Recording, compensation: Compensation) -> tuple[Array, Array]:
    gyro = recording.gyro @ compensation.gyro_matrix.T + compensation.gyro_bias * recording.dt
    accel = recording.accel @ compensation.accelerometer_matrix.T + compensation.accelerometer_bias * recording.dt
    return gyro, accel


def _mean(increments: Array, dt: float) -> tuple[Array, Array]:
    """Mean rate of increments, shape (n, 3), and its standard deviation from the scatter of blocks."""
    steps = min(max(1, round(BLOCK / dt)), len(increments) // 4)
    count = len(increments) // steps
    blocks = increments[: count * steps].reshape(count, steps, 3).mean(axis=1) / dt
    return increments.mean(axis=0) / dt, blocks.std(axis=0, ddof=1) / np.sqrt(count)


def _yaw(trajectory: Trajectory, nodes: slice, upright: int) -> Array:
    """Angle from north, clockwise, of the body axis after the one that stands upright; continuous."""
    pointer = trajectory.C_b_n[nodes, :, (upright + 1) % 3]
    return np.unwrap(np.arctan2(pointer[:, 0], pointer[:, 1]))


def _start(
    attitude: str | ArrayLike, recording: Recording, compensation: Compensation, azimuth: float, down: Array
) -> Array:
    if not isinstance(attitude, str):
        return checks.rotation_matrix("initial_attitude", checks.finite_array("initial_attitude", attitude, (3, 3)))
    planned = dcm_from_rotvec([0, 0, -checks.finite("azimuth", azimuth, "rad")]) @ recording.test.C_b_n
    if checks.option("initial_attitude", attitude, ("levelled", "model")) == "model":
        return planned
    force = compensation.accelerometer_matrix @ recording.forces[0] + compensation.accelerometer_bias
    return levelled(planned, force, down)


def _require_half_turn(test: TurnTest) -> None:
    checks.instance("test", test, TurnTest)
    upright = abs(test.C_b_n[2] @ test.axis)
    rest = np.cos(test.angle)
    if upright < 0.99 or rest > -0.99:  # 8 deg off
        raise ValueError(
            "`test` must be half a turn about an axis that stands upright, as `bias_test()`, got "
            f"{np.rad2deg(test.angle):.4g} deg about an axis {np.rad2deg(np.arccos(min(upright, 1))):.3g} deg off it"
        )


def _require_plausible(recording: Recording, compensation: Compensation, gravity: float) -> None:
    plausibility.check([recording], compensation, gravity)
    gyro, _ = _compensated(recording, compensation)
    for number, dwell in enumerate(recording.dwells, start=1):
        plausibility.warn_of_drift(gyro[slice(*dwell)] / recording.dt, recording.dt, f"dwell {number} of `recording`")


def _frame(rows: list[dict[str, float]]) -> "DataFrame":
    import pandas as pd

    return pd.DataFrame(rows, index=pd.Index(range(1, len(rows) + 1), name="iteration"))
