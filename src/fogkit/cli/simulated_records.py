"""What does a unit record while a plan is carried out? Tables of whole recordings, turns between positions included."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.imu.errors import GyroTriad
from fogkit.imu.tables import GYRO_COLUMNS, IMU_COLUMNS
from fogkit.imu.unit import MeasurementUnit
from fogkit.io.plan_names import MountScan
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand import RoughTable, turn_recordings
from fogkit.stand.placements import attitude
from fogkit.stand.plans import Plan
from fogkit.stand.table import RateTable
from fogkit.stand.turn_tests import TurnTest

Array = NDArray[np.float64]

HANDLING = 3.0
"""Time, s, in which an operator turns a unit from one attitude to the next."""


def steady(C_b_n: Array, rate: Array, count: int, dt: float, lat: float) -> tuple[Array, Array]:
    """Mean rate and specific force in samples of a turn at a constant rate about a body axis, from an attitude.

    Vectors fixed in the room are taken in the middle of each sample and shortened as their mean over it is.
    """
    rate = np.asarray(rate, dtype=float)
    size = float(np.linalg.norm(rate))
    middle = C_b_n @ dcm_from_rotvec(((np.arange(count) + 0.5) * dt)[:, None] * rate)
    axis = rate / size if size else np.zeros(3)

    def seen(vector_n: Array) -> Array:
        v = vector_n @ middle  # C_b_n.T @ vector
        along = (v @ axis)[:, None] * axis
        return along + np.sinc(0.5 * size * dt / np.pi) * (v - along)

    return seen(earth_rate_n(lat)) + rate, seen(np.array([0.0, 0.0, normal_gravity(lat)]))


def handled(C_from: Array, C_to: Array, dt: float, lat: float, duration: float = HANDLING) -> tuple[Array, Array]:
    """The same while an operator turns the unit from one attitude to another; smooth, at rest at both ends."""
    count = max(2, round(duration / dt))
    vector = Rotation.from_matrix(C_from.T @ C_to).as_rotvec()
    edges = np.linspace(0, 1, count + 1)
    way = edges - np.sin(2 * np.pi * edges) / (2 * np.pi)
    middle = C_from @ dcm_from_rotvec((0.5 * (way[1:] + way[:-1]))[:, None] * vector)
    rates = np.diff(way)[:, None] / dt * vector
    return earth_rate_n(lat) @ middle + rates, np.array([0.0, 0.0, normal_gravity(lat)]) @ middle


def on_rough_table(
    unit: MeasurementUnit, plan: tuple[TurnTest, ...], dt: float, lat: float, rng: np.random.Generator
) -> dict[str, Array]:
    """Dwells and turns on a table good to some tenths of a degree, the unit set up anew where the plan says so."""
    tables = turn_recordings.record(unit, RoughTable.typical(lat).motions(plan, rng), 1 / dt, rng=rng)
    parts, before = [], None
    for test, table in zip(plan, tables, strict=True):
        C_b_n = np.asarray(test.C_b_n)
        if before is not None and not np.allclose(before, C_b_n):
            parts.append(_read(unit, *handled(before, C_b_n, dt, lat), dt, rng))
        parts.append(table.to_numpy() / dt)
        before = np.asarray(test.C_b_n_end)
    return _columns(np.concatenate(parts), dt)


def on_mount(
    unit: MeasurementUnit, scan: MountScan, dt: float, lat: float, heading: float, rng: np.random.Generator
) -> dict[str, Array]:
    """Dwells and turns on a mount that stands turned by a heading, clockwise, from what the letters say."""
    axis = np.eye(3)["xyz".index(scan.axis)]
    start = dcm_from_rotvec(np.array([0.0, 0.0, -heading])) @ attitude(scan.start)
    omega, force, angles = [], [], []
    for i, angle in enumerate(scan.angles):
        C_b_n = start @ dcm_from_rotvec(axis * (scan.angles[i - 1] if i else angle))
        if i:
            count = max(2, round(scan.turn_duration / dt))
            rate = (angle - scan.angles[i - 1]) / (count * dt)
            motion = steady(C_b_n, rate * axis, count, dt, lat)
            omega.append(motion[0])
            force.append(motion[1])
            angles.append(scan.angles[i - 1] + rate * dt * np.arange(count))
        count = max(2, round(scan.dwell / dt))
        motion = steady(start @ dcm_from_rotvec(axis * angle), np.zeros(3), count, dt, lat)
        omega.append(motion[0])
        force.append(motion[1])
        angles.append(np.full(count, angle))
    readings = _read(unit, np.concatenate(omega), np.concatenate(force), dt, rng)
    return _columns(readings, dt) | {"angle": np.concatenate(angles)}


def on_rate_table(
    triad: GyroTriad, plan: Plan, table: RateTable, dt: float, rng: np.random.Generator
) -> dict[str, Array]:
    """Gyros alone, with the readout of the table and the labels of the plan; between steps the table turns on."""
    readings, angles, labels = [], [], []
    before = None
    for segment, C_0_g1 in zip(plan.segments, plan.C_0_g1, strict=True):
        C_0_n = table.C_0_n(segment.outer, segment.middle, segment.inner)
        if before is not None:
            between = handled(before, C_0_n, dt, table.latitude)[0]
            readings.append(_gyro_readings(triad, between @ C_0_g1.T, dt, rng))
            angles.append(np.zeros(len(between)))
            labels += [None] * len(between)
        axis = table.axis_in_case(segment.turning or "outer", segment.middle, segment.inner)
        count = max(2, round(segment.duration / dt))
        omega, _ = steady(C_0_n, segment.rate * axis, count, dt, table.latitude)
        readings.append(_gyro_readings(triad, omega @ C_0_g1.T, dt, rng))
        angles.append(np.arange(count) * dt * segment.rate + table.readout_noise * rng.standard_normal(count))
        labels += [segment.label] * count
        before = C_0_n @ dcm_from_rotvec(count * dt * segment.rate * axis)
    values = np.concatenate(readings)
    columns = {"time": np.arange(len(values)) * dt} | dict(zip(GYRO_COLUMNS, values.T, strict=True))
    return columns | {"angle": np.concatenate(angles), "position": np.array(labels, dtype=object)}


def _gyro_readings(triad: GyroTriad, rates: Array, dt: float, rng: np.random.Generator) -> Array:
    """Readings of gyros, the scale factor by the sign of the input, with white noise."""
    along = rates @ triad.A_g.T
    scale = np.where(along > 0, triad.scale_positive, triad.scale_negative)
    noise = triad.angle_random_walk / np.sqrt(dt) * rng.standard_normal(along.shape)
    return np.array(triad.bias) + along / scale + noise


def _read(unit: MeasurementUnit, omega: Array, force: Array, dt: float, rng: np.random.Generator) -> Array:
    """Readings of a unit, shape (n, 6)."""
    return np.hstack([unit.gyros.readings(omega, dt, rng, force), unit.accelerometers.readings(force, dt, rng)])


def _columns(values: Array, dt: float) -> dict[str, Array]:
    """Time and readings by column."""
    return {"time": np.arange(len(values)) * dt} | dict(zip(IMU_COLUMNS, values.T, strict=True))
