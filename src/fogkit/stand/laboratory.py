"""The laboratory: a plate or a single-axis rate table with its errors, and what a unit reads on it.

The plate, or the axis of the table, stands upright but for small errors; the unit lies on it in a cube whose faces have
errors of their own. Both are rotations: those of the plate stay in the room while the unit is turned over, those of the
cube and of the mounting turn with it. That difference decides which errors a plan cancels.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.unit import MeasurementUnit
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.placements import Placement, Schedule

if TYPE_CHECKING:
    from pandas import DataFrame

FACES = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Faces of the cube by the axis that points up on them."""


@dataclass(frozen=True, kw_only=True)
class Laboratory:
    """A place, and the errors of what stands there.

    Parameters
    ----------
    latitude : float
        Geodetic latitude, rad.
    gravity : float, optional
        Gravity, m/s^2; by default normal gravity at the latitude (`dataclasses.replace` of the latitude keeps it).
    level_east, level_north : float, optional
        Small rotation of the plate, or of the table's axis, about east and north, rad.
    azimuth_error : float, optional
        Rotation of the plate's north mark about up, counter-clockwise positive, rad.
    faces : array_like, shape (6, 3), optional
        Small rotation of the unit, about its own axes, on each face of the cube in the order of `FACES`, rad.
    mounting : array_like, shape (3,), optional
        Small rotation of the unit's axes against the cube, the same on every face, rad.
    placement_error : float, optional
        Standard deviation of a rotation about each axis that is drawn anew at each placement, rad.
    turn_error : float, optional
        Standard deviation of the angle of a turn, rad.
    rate_error : float, optional
        Standard deviation of a rate of the table, relative to it.

    Raises
    ------
    ValueError
        If a number is not finite, a deviation negative, the latitude beyond a pole, or an angle 0.5 rad or more.
    """

    latitude: float
    gravity: float = 0.0
    level_east: float = 0.0
    level_north: float = 0.0
    azimuth_error: float = 0.0
    faces: ArrayLike = field(default=((0.0,) * 3,) * 6)
    mounting: ArrayLike = field(default=(0.0,) * 3)
    placement_error: float = 0.0
    turn_error: float = 0.0
    rate_error: float = 0.0

    def __post_init__(self) -> None:
        fix = "Multiply degrees by `fogkit.units.DEG`."
        checks.in_closed_interval("latitude", self.latitude, -np.pi / 2, np.pi / 2, "rad", fix=fix)
        gravity = checks.non_negative("gravity", self.gravity, "m/s^2") or float(normal_gravity(self.latitude))
        object.__setattr__(self, "gravity", gravity)
        for name in ("level_east", "level_north", "azimuth_error"):
            checks.in_open_interval(name, getattr(self, name), -0.5, 0.5, "rad")
        for name, shape in (("faces", (6, 3)), ("mounting", (3,))):
            angles = checks.finite_array(name, getattr(self, name), shape=shape)
            checks.array_in_closed_interval(name, angles, -0.5, 0.5, "rad")
            object.__setattr__(
                self, name, tuple(map(tuple, angles.tolist())) if angles.ndim > 1 else tuple(angles.tolist())
            )
        for name in ("placement_error", "turn_error", "rate_error"):
            checks.non_negative(name, getattr(self, name))

    @property
    def omega_ie_n(self) -> NDArray[np.float64]:
        """Rotation of the Earth in east, north, up, rad/s, shape (3,)."""
        return earth_rate_n(self.latitude)

    @cached_property
    def C_plate_n(self) -> NDArray[np.float64]:
        """Direction cosines from the plate's own east, north, up to the true ones, shape (3, 3)."""
        return dcm_from_rotvec([self.level_east, self.level_north, self.azimuth_error])

    def C_b_plate(self, placement: Placement) -> NDArray[np.float64]:
        """Direction cosines from the unit to the plate at the start of a placement, shape (3, 3)."""
        axis, sign = placement.vertical
        face = self.faces[2 * axis + (sign < 0)]
        return placement.C_b_n @ dcm_from_rotvec(face) @ dcm_from_rotvec(self.mounting)

    def mean_inputs(
        self, placement: Placement, start: ArrayLike = 0.0, stop: ArrayLike | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean rate and specific force in axes of the unit between two times of a placement, in closed form.

        Parameters
        ----------
        placement : Placement
            How the unit lies and turns.
        start, stop : array_like, shape (...,), optional
            Times from the beginning of the placement, s; by default all of it.

        Returns
        -------
        omega_ib_b, f_ib_b : ndarray, shape (..., 3)
            rad/s and m/s^2.
        """
        return _mean_inputs(self, placement, placement.rate, self.C_b_plate(placement), start, stop)

    def record(
        self,
        unit: MeasurementUnit,
        schedule: Schedule,
        rng: np.random.Generator,
        *,
        sample_rate: float = 10.0,
    ) -> "DataFrame":
        """What a unit reads while a schedule is carried out.

        Parameters
        ----------
        unit : MeasurementUnit
            The unit; its readings are means over each sample.
        schedule : Schedule
            What the operator does. The time between placements is left out.
        rng : numpy.random.Generator
            Source of all random errors.
        sample_rate : float, optional
            Samples per second. Each placement takes the nearest whole number of samples, at least two.

        Returns
        -------
        pandas.DataFrame
            Index ``time``, s, the beginning of each sample; columns ``gyro_x`` to ``accel_z`` in the units of the
            sensors' readings, and ``position`` with the labels.

        Raises
        ------
        ValueError
            If a placement is shorter than two samples, or the unit has delays or a size effect.
        """
        import pandas as pd

        checks.instance("unit", unit, MeasurementUnit)
        unit.require_point("a recording on a plate")
        checks.instance("schedule", schedule, Schedule)
        dt = 1 / checks.positive("sample_rate", sample_rate, "Hz")
        checks.generator("rng", rng)
        parts, counts = [], []
        for placement in schedule.placements:
            count = round(placement.duration / dt)
            if count < 2:
                raise ValueError(
                    f"`sample_rate` must give each placement two samples, got {sample_rate} Hz for "
                    f"{placement.label!r} of {placement.duration:g} s"
                )
            edges = np.linspace(0.0, placement.duration, count + 1)
            parts.append(_mean_inputs(self, *self._drawn(placement, rng), edges[:-1], edges[1:]))
            counts.append(count)
        omega, force = (np.concatenate(part) for part in zip(*parts, strict=True))
        gyros = unit.gyros.readings(omega, dt, rng, force)
        accelerometers = unit.accelerometers.readings(force, dt, rng)
        time = pd.Index(np.arange(len(omega)) * dt, name="time")
        table = pd.DataFrame(np.hstack([gyros, accelerometers]), index=time, columns=list(IMU_COLUMNS))
        codes = np.repeat(np.arange(len(schedule)), counts)
        return table.assign(position=pd.Categorical.from_codes(codes, schedule.labels))

    def _drawn(self, placement: Placement, rng: np.random.Generator) -> tuple[Placement, float, NDArray[np.float64]]:
        """A placement as it comes out: itself, its rate and its attitude on the plate."""
        C_b_plate, rate = self.C_b_plate(placement), placement.rate
        if self.placement_error:
            C_b_plate = C_b_plate @ dcm_from_rotvec(self.placement_error * rng.standard_normal(3))
        if rate:
            turn, relative = rng.standard_normal(2)
            rate = rate * (1 + self.rate_error * relative) + self.turn_error * turn / placement.duration
        return placement, rate, C_b_plate


def _mean_inputs(
    laboratory: Laboratory,
    placement: Placement,
    rate: float,
    C_b_plate: NDArray[np.float64],
    start: ArrayLike,
    stop: ArrayLike | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As `Laboratory.mean_inputs`, of a placement that came out with another rate and attitude."""
    start = np.asarray(start, float)
    stop = np.asarray(placement.duration if stop is None else stop, float)
    middle, half = rate * (start + stop) / 2, rate * (stop - start) / 2
    shrink = np.sinc(half / np.pi)  # mean of a cosine over an arc, less its value at the middle
    upright = np.array([0.0, 0.0, 1.0])

    def seen(vector_n: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean of a vector fixed in the room, in axes of the unit, which turns about the plate's normal."""
        x, y, z = laboratory.C_plate_n.T @ vector_n
        c, s = shrink * np.cos(middle), shrink * np.sin(middle)
        turned = np.stack([c * x + s * y, c * y - s * x, np.broadcast_to(z, middle.shape)], axis=-1)
        return turned @ C_b_plate

    omega = seen(laboratory.omega_ie_n) + rate * upright @ C_b_plate
    return omega, seen(np.array([0.0, 0.0, laboratory.gravity]))
