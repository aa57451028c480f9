"""Recordings for the tests of `fogkit.io`: of every plan, with errors that are known."""

import numpy as np
import pandas as pd

from fogkit import io
from fogkit.constants import STANDARD_GRAVITY
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.imu import LinearTriad, MeasurementUnit, Sensors
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.io.plan_names import MountScan
from fogkit.noise import RandomErrors
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand import Laboratory, RateTable
from fogkit.stand.placements import attitude
from fogkit.units import DEG, DEG_PER_HOUR, DEG_PER_SQRT_HOUR

LATITUDE = 60 * DEG

GYROS = LinearTriad(bias=np.array([1.0, -2.0, 0.5]) * DEG_PER_HOUR)
ACCELEROMETERS = LinearTriad(bias=np.array([1e-3, -2e-3, 3e-3]) * STANDARD_GRAVITY)

UNIT = MeasurementUnit(
    gyros=Sensors(triad=GYROS, random=RandomErrors(angle_random_walk=0.005 * DEG_PER_SQRT_HOUR)),
    accelerometers=Sensors(triad=ACCELEROMETERS, random=RandomErrors(angle_random_walk=1e-4)),
)


def in_laboratory(kind, seed=1, sample_rate=20.0, unit=UNIT, **parameters):
    """Table of a schedule, its labels included, and the reference to its plan."""
    reference = io.PlanReference(kind=kind, parameters=parameters)
    laboratory = Laboratory(latitude=LATITUDE)
    rng = np.random.default_rng(seed)
    return laboratory.record(unit, reference.build(), rng, sample_rate=sample_rate), reference


def moved(C_b_n, rate, duration, dt, rng, noise=1e-6):
    """Readings of a unit that rests, or turns at a constant rate about a body axis: ideal but for noise and a bias."""
    count = round(duration / dt)
    angle = (np.arange(count) + 0.5) * dt
    attitudes = C_b_n @ dcm_from_rotvec(angle[:, None] * np.asarray(rate, dtype=float))
    earth, up = earth_rate_n(LATITUDE), np.array([0.0, 0.0, normal_gravity(LATITUDE)])
    gyro = np.einsum("nji,j->ni", attitudes, earth) + rate + np.array([1.0, -2.0, 0.5]) * DEG_PER_HOUR
    accel = np.einsum("nji,j->ni", attitudes, up)
    readings = np.hstack([gyro, accel]) + rng.standard_normal((count, 6)) * np.repeat([noise, 100 * noise], 3)
    return readings, attitudes[-1] @ dcm_from_rotvec(0.5 * dt * np.asarray(rate, dtype=float))


def table_of(parts, dt):
    """The one table from readings that follow one another."""
    values = np.concatenate(parts)
    return pd.DataFrame(values, index=pd.Index(np.arange(len(values)) * dt, name="time"), columns=list(IMU_COLUMNS))


def on_rate_table(plan, dt, rng):
    """Table with the readout's angle, of a three-stage plan, with a turn of the table between two steps."""
    table = RateTable(latitude=LATITUDE)
    parts, angles = [], []
    for s in plan.segments:
        axis = table.axis_in_case(s.turning or "outer", s.middle, s.inner)
        readings, _ = moved(table.C_0_n(s.outer, s.middle, s.inner), s.rate * axis, s.duration, dt, rng)
        between, _ = moved(np.eye(3), [0.0, 0.3, 0.2], 2.0, dt, rng)
        between[:, :3] *= np.linspace(0.2, 1, len(between))[:, None]
        parts += [readings, between]
        angles += [np.arange(len(readings)) * dt * s.rate, np.zeros(len(between))]
    return table_of(parts, dt).assign(angle=np.concatenate(angles))


def on_mount(scan: MountScan, dt, rng):
    """Table of a scan: dwells and turns of constant rate one after the other."""
    C_b_n = attitude(scan.start) @ dcm_from_rotvec(np.eye(3)["xyz".index(scan.axis)] * scan.angles[0])
    parts = []
    for i, angle in enumerate(scan.angles):
        if i:
            rate = np.eye(3)["xyz".index(scan.axis)] * (angle - scan.angles[i - 1]) / scan.turn_duration
            turn, C_b_n = moved(C_b_n, rate, scan.turn_duration, dt, rng)
            parts.append(turn)
        dwell, _ = moved(C_b_n, np.zeros(3), scan.dwell, dt, rng)
        parts.append(dwell)
    return table_of(parts, dt)
