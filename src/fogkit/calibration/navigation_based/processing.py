"""Navigation of all tests with the present parameters: slopes, attitudes, and the sums that the matrix needs."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fogkit import checks, earth
from fogkit.calibration.navigation_based import _kernels
from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.recordings import Recording, checked_plan, recordings_of
from fogkit.calibration.navigation_based.slopes import SlopeFit
from fogkit.navigation import State, integrate_arrays
from fogkit.rotation import dcm_from_rotvec, orthonormalise
from fogkit.stand.turn_tests import TurnTest

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

INITIAL_ATTITUDES = ("model", "levelled", "carried")
_WORTH_THREADS = 60_000  # steps; below, two threads take longer than one
_CHAINED = 1e-6  # largest difference of an end and a start, as matrices, in a plan that carries on


@dataclass(frozen=True, kw_only=True, eq=False)
class Processed:
    """What the navigation of all tests gave; axes: tests, then the two dwells.

    Attributes
    ----------
    slopes, variances : ndarray, shape (tests, 2, 3)
        Slopes of the velocity, east, north, up, m/s^2, and their variances (24).
    forces : ndarray, shape (tests, 2, 3)
        Mean compensated readings of the accelerometers, m/s^2, body axes.
    attitudes : ndarray, shape (tests, 2, 3, 3)
        Computed ``C_b_n`` at the end of the first and at the beginning of the second dwell.
    starts, ends : ndarray, shape (tests, 3, 3)
        Attitude that the navigation started from, and that at the end of the recording.
    projections : ndarray, shape (tests, 3, 3, 3)
        Sums (12), rad.
    """

    slopes: Array
    variances: Array
    forces: Array
    attitudes: Array
    starts: Array
    ends: Array
    projections: Array

    @property
    def change(self) -> Array:
        """Measurement vector (6), (7): east and north of each test, m/s^2, shape (2 * tests,)."""
        return (self.slopes[:, 1, :2] - self.slopes[:, 0, :2]).ravel()

    @property
    def change_variance(self) -> Array:
        """Variances (23) of the measurement vector, shape (2 * tests,)."""
        return self.variances[:, :, :2].sum(axis=1).ravel()


class Processing:
    """Recordings made ready to be navigated again and again.

    Parameters
    ----------
    recordings : sequence of Recording
        The tests.
    latitude, altitude : float
        Where the table stands, rad and m.
    gravity : ndarray, shape (3,)
        Gravity there, east, north, up, m/s^2.
    starts : str or ndarray, shape (tests, 3, 3)
        ``"model"``: as planned. ``"levelled"``: the nearest attitude in which the accelerometers' mean reading of the
        first dwell shows up. ``"carried"``: the same, from the computed end of the test before wherever the plan starts
        a test as it ended one. Or the attitudes.
    azimuth : float
        Angle, rad, clockwise seen from above, by which all attitudes of the plan are turned.
    degree : {1, 2}
        Of the polynomials through the velocity.
    corrections : str
        As of `fogkit.navigation.integrate_arrays`.
    """

    def __init__(
        self,
        recordings: Sequence[Recording],
        latitude: float,
        altitude: float,
        gravity: Array,
        starts: str | Array,
        azimuth: float,
        degree: int,
        corrections: str,
    ) -> None:
        self.recordings = tuple(recordings)
        self._place = {"lat": latitude, "alt": altitude}
        self.gravity, self._corrections, self._degree = gravity, corrections, degree
        self._raw_forces = np.stack([recording.forces for recording in recordings])
        self._levelled = isinstance(starts, str) and starts != "model"
        planned = np.stack([recording.test.C_b_n for recording in recordings])
        self.nominal = dcm_from_rotvec([0, 0, -azimuth]) @ planned if isinstance(starts, str) else starts
        self._before = _predecessors(self.recordings) if isinstance(starts, str) and starts == "carried" else {}
        self._batches = _batches(self.recordings, self._before, degree)

    def run(self, compensation: Compensation, starts: Array | None = None) -> Processed:
        """Navigate all tests; with `starts`, shape (tests, 3, 3), from those attitudes."""
        count = len(self.recordings)
        forces = self._raw_forces @ compensation.accelerometer_matrix.T + compensation.accelerometer_bias
        found = Processed(
            slopes=np.empty((count, 2, 3)),
            variances=np.empty((count, 2, 3)),
            forces=forces,
            attitudes=np.empty((count, 2, 3, 3)),
            starts=np.empty((count, 3, 3)),
            ends=np.empty((count, 3, 3)),
            projections=np.empty((count, 3, 3, 3)),
        )
        for stage in self._batches:
            for test in (test for batch in stage for test in batch.tests):
                found.starts[test] = self._start(test, found) if starts is None else starts[test]
            if len(stage) > 1 and sum(batch.gyro.size for batch in stage) >= 3 * _WORTH_THREADS:
                with ThreadPoolExecutor(os.cpu_count()) as pool:
                    list(pool.map(lambda batch: self._navigate(batch, compensation, found), stage))
            else:
                for batch in stage:
                    self._navigate(batch, compensation, found)
        return found

    def _start(self, test: int, found: Processed) -> Array:
        before = self._before.get(test)
        nominal = self.nominal[test] if before is None else found.ends[before]
        return levelled(nominal, found.forces[test, 0], self.gravity) if self._levelled else nominal

    def _navigate(self, batch: "_Batch", compensation: Compensation, found: Processed) -> None:
        matrices = (compensation.gyro_matrix, compensation.gyro_bias)
        matrices += (compensation.accelerometer_matrix, compensation.accelerometer_bias)
        gyro, accel = batch.scratch
        _kernels.compensate(batch.gyro, batch.accel, batch.dt, *matrices, gyro, accel)
        tests = list(batch.tests)
        trajectory = integrate_arrays(
            gyro,
            accel,
            batch.dt,
            State(C_b_n=orthonormalise(found.starts[tests]), **self._place),
            gravity=self.gravity,
            corrections=self._corrections,
            velocity_reset=[batch.dwells[1][0] * batch.dt],
            position_fixed=True,
        )
        projections = np.empty((len(tests), 3, 3, 3))
        stop, begin = batch.dwells[0][1], batch.dwells[1][0]
        _kernels.project(trajectory.quaternion, gyro, stop, begin, projections)
        found.projections[tests] = projections
        nodes = trajectory.quaternion[:, [stop, begin, -1]]
        attitudes = Rotation.from_quat(nodes.reshape(-1, 4)).as_matrix().reshape(len(tests), 3, 3, 3)
        found.attitudes[tests], found.ends[tests] = attitudes[:, :2], attitudes[:, 2]
        for dwell, ((first, last), fit) in enumerate(zip(batch.dwells, batch.fits, strict=True)):
            velocity = trajectory.v_eb_n[:, first : last + 1]
            if self._degree > 1:
                velocity = velocity + self._coriolis(velocity, batch.dt)
            found.slopes[tests, dwell], found.variances[tests, dwell] = fit(velocity[:, 1:])

    def _coriolis(self, velocity: Array, dt: float) -> Array:
        """What the Coriolis term has taken from the velocity, shape (tests, k, 3), since it was zero at the first node.

        It grows anew in each dwell, so beyond a dwell, where a parabola is continued to, it would be another one.
        """
        moved = np.zeros_like(velocity)
        np.cumsum(0.5 * dt * (velocity[:, 1:] + velocity[:, :-1]), axis=1, out=moved[:, 1:])
        return 2 * np.cross(earth.earth_rate_n(self._place["lat"]), moved)


def prepare(
    recordings: Sequence["DataFrame"],
    plan: Sequence[TurnTest],
    latitude: float,
    *,
    altitude: float = 0.0,
    gravity: float | ArrayLike | None = None,
    initial_attitude: str | ArrayLike = "model",
    azimuth: float = 0.0,
    degree: int = 1,
    settle: float = 0.0,
    dwells: str = "plan",
    corrections: str = "central",
) -> Processing:
    """Recordings ready to be navigated with any compensation: what `calibrate` iterates.

    Parameters
    ----------
    recordings, plan, latitude, altitude, gravity, initial_attitude, azimuth, degree, settle, dwells, corrections
        As for `calibrate`.

    Returns
    -------
    Processing
        `Processing.run` navigates all tests.

    Raises
    ------
    TypeError, ValueError
        As `calibrate`, but for what needs a compensation to be seen.
    """
    plan = checked_plan(plan)
    prepared = recordings_of(recordings, plan, settle=settle, dwells=dwells)
    latitude = float(earth.checked_latitude(latitude, "latitude", earth.POLE_MARGIN))
    altitude = checks.finite("altitude", altitude, "m")
    if isinstance(initial_attitude, str):
        checks.option("initial_attitude", initial_attitude, INITIAL_ATTITUDES)
    else:
        initial_attitude = checks.finite_array("initial_attitude", initial_attitude, shape=(len(plan), 3, 3))
        checks.rotation_matrix("initial_attitude", initial_attitude)
    if checks.integer("degree", degree) not in (1, 2):
        raise ValueError(f"`degree` must be 1 or 2, got {degree}")
    return Processing(
        prepared,
        latitude,
        altitude,
        gravity_vector(gravity, latitude, altitude),
        initial_attitude,
        checks.finite("azimuth", azimuth, "rad"),
        int(degree),
        corrections,
    )


def gravity_vector(gravity: float | ArrayLike | None, latitude: float, altitude: float) -> Array:
    """Gravity at a place, east, north, up, m/s^2, from None for the normal one, a magnitude, or a vector."""
    if gravity is None:
        return earth.gravity_n(latitude, altitude)
    vector = checks.finite_array("gravity", gravity)
    if vector.shape == ():
        return np.array([0.0, 0.0, -checks.positive("gravity", float(vector), "m/s^2")])
    return checks.finite_array("gravity", vector, shape=(3,))


def levelled(C_b_n: ArrayLike, force: ArrayLike, gravity: ArrayLike = (0.0, 0.0, -1.0)) -> Array:
    """Attitude nearest to a given one in which a specific force, felt at rest, balances gravity.

    Parameters
    ----------
    C_b_n : array_like, shape (3, 3)
        Attitude whose heading is kept.
    force : array_like, shape (3,)
        Mean specific force in body axes, of any unit.
    gravity : array_like, shape (3,), optional
        Direction of gravity in n.

    Returns
    -------
    ndarray, shape (3, 3)
        `C_b_n` turned about the level axis across the two directions: the smallest rotation that does it.
    """
    felt, up = np.asarray(C_b_n) @ np.asarray(force, dtype=float), -np.asarray(gravity, dtype=float)
    across = np.cross(felt, up)
    sine, cosine = np.linalg.norm(across), felt @ up
    axis = across / sine if sine > 0 else np.array([1.0, 0.0, 0.0])
    return dcm_from_rotvec(axis * np.arctan2(sine, cosine)) @ C_b_n


@dataclass(frozen=True, eq=False)
class _Batch:
    """Tests of the same length, step and dwells, navigated in one call."""

    tests: tuple[int, ...]
    dt: float
    gyro: Array  # shape (tests, n, 3)
    accel: Array
    dwells: tuple[tuple[int, int], tuple[int, int]]
    fits: tuple[SlopeFit, SlopeFit]
    scratch: tuple[Array, Array]  # compensated increments, written anew in each iteration


def _batches(recordings: tuple[Recording, ...], before: dict[int, int], degree: int) -> list[list[_Batch]]:
    """Stages one after the other; the batches of a stage may run side by side."""
    stage = [0] * len(recordings)
    for test in range(len(recordings)):
        stage[test] = stage[before[test]] + 1 if test in before else 0
    stages, fits = [], {}
    for level in range(max(stage) + 1):
        kinds: dict[tuple, list[int]] = {}
        for test, recording in enumerate(recordings):
            if stage[test] == level:
                kinds.setdefault((len(recording.gyro), recording.dt, recording.dwells), []).append(test)
        for kind, tests in kinds.items():
            fits.setdefault(kind[1:], _fits(recordings[tests[0]], degree))
        stages.append(
            [
                _batch([recordings[test] for test in part], tuple(part), fits[kind[1:]])
                for kind, tests in kinds.items()
                for part in _parts(recordings, tests)
            ]
        )
    return stages


def _parts(recordings: tuple[Recording, ...], tests: list[int]) -> list[list[int]]:
    """Tests shared out among the processors, if that is worth it."""
    steps = sum(len(recordings[test].gyro) for test in tests)
    workers = min(os.cpu_count() or 1, len(tests)) if steps >= _WORTH_THREADS else 1
    return [tests[i::workers] for i in range(workers)]


def _batch(recordings: list[Recording], tests: tuple[int, ...], fits: tuple[SlopeFit, SlopeFit]) -> _Batch:
    gyro = np.stack([recording.gyro for recording in recordings])
    accel = np.stack([recording.accel for recording in recordings])
    scratch = np.empty_like(gyro), np.empty_like(accel)
    return _Batch(tests, recordings[0].dt, gyro, accel, recordings[0].dwells, fits, scratch)


def _predecessors(recordings: tuple[Recording, ...]) -> dict[int, int]:
    """For each test that the plan starts as it ended the one before: the number of that one."""
    tests = [recording.test for recording in recordings]
    chained = (np.abs(b.C_b_n - a.C_b_n_end).max() <= _CHAINED for a, b in pairwise(tests))
    return {i + 1: i for i, follows in enumerate(chained) if follows}


def _fits(recording: Recording, degree: int) -> tuple[SlopeFit, SlopeFit]:
    """Fits of both dwells: over the nodes after the first, at which the velocity is zero by force."""
    (_, stop), (begin, _) = recording.dwells
    middle = 0.5 * (stop + begin) * recording.dt if degree > 1 else None
    times = [recording.dt * np.arange(first + 1, last + 1) for first, last in recording.dwells]
    return SlopeFit.of(times[0], degree, middle), SlopeFit.of(times[1], degree, middle)
