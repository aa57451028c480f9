"""States of a navigation: at one time, and along a run.

The state is that of the body b against the Earth e in axes of n, as in `fogkit.rotation` and `fogkit.earth`.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fogkit import checks, earth

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

#: Columns of `Trajectory.to_frame`: rad, m, m/s.
TRAJECTORY_COLUMNS = (
    *("lat", "lon", "alt"),
    *("velocity_east", "velocity_north", "velocity_up"),
    *("heading", "pitch", "roll"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """Where a body is, how fast it moves and how it stands; or many of them.

    Parameters
    ----------
    lat : array_like, shape (...,)
        Geodetic latitude, rad, at least `fogkit.earth.POLE_MARGIN` from a pole.
    C_b_n : array_like, shape (..., 3, 3)
        Attitude.
    v_eb_n : array_like, shape (..., 3), optional
        Velocity relative to the Earth, east, north, up, m/s; at rest by default.
    lon, alt : array_like, shape (...,), optional
        Longitude, rad, and height above the ellipsoid, m.

    Raises
    ------
    ValueError
        If an argument is out of range or not finite, or shapes do not broadcast to each other.

    Notes
    -----
    The fields are arrays, broadcast to the common shape `shape` of leading axes.
    """

    lat: ArrayLike
    C_b_n: ArrayLike
    v_eb_n: ArrayLike = (0.0, 0.0, 0.0)
    lon: ArrayLike = 0.0
    alt: ArrayLike = 0.0
    shape: tuple[int, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        fields = {
            "lat": (earth.checked_latitude(self.lat, pole_margin=earth.POLE_MARGIN), 0),
            "C_b_n": (checks.rotation_matrix("C_b_n", self.C_b_n), 2),
            "v_eb_n": (checks.finite_array("v_eb_n", self.v_eb_n, shape=(..., 3)), 1),
            "lon": (checks.finite_array("lon", self.lon), 0),
            "alt": (checks.finite_array("alt", self.alt), 0),
        }
        leading = {name: value.shape[: value.ndim - axes] for name, (value, axes) in fields.items()}
        try:
            shape = np.broadcast_shapes(*leading.values())
        except ValueError:
            raise ValueError(f"leading axes must broadcast to each other, got {leading}") from None
        object.__setattr__(self, "shape", shape)
        for name, (value, axes) in fields.items():
            object.__setattr__(self, name, np.broadcast_to(value, shape + value.shape[value.ndim - axes :]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory:
    """What a navigation gives: states at times, of one run or, in leading axes, of many.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        Time, s; the first row is the start.
    lat, lon, alt : ndarray, shape (..., rows)
        Geodetic latitude and longitude, rad, and height above the ellipsoid, m.
    v_eb_n : ndarray, shape (..., rows, 3)
        Velocity relative to the Earth, east, north, up, m/s.
    quaternion : ndarray, shape (..., rows, 4), or None
        Attitude as unit quaternion of `C_b_n`, scalar last as in SciPy; None if it was not kept.
    """

    time: Array
    lat: Array
    lon: Array
    alt: Array
    v_eb_n: Array
    quaternion: Array | None

    @cached_property
    def C_b_n(self) -> Array:
        """Attitude, shape (..., rows, 3, 3)."""
        return self._rotation().as_matrix().reshape(*self.quaternion.shape[:-1], 3, 3)

    @cached_property
    def heading_pitch_roll(self) -> tuple[Array, Array, Array]:
        """Angles, rad, each of shape (..., rows), as `fogkit.rotation.heading_pitch_roll_from_dcm` has them."""
        angles = self._rotation().as_euler("ZXY").reshape(*self.quaternion.shape[:-1], 3)
        return -angles[..., 0], angles[..., 1], angles[..., 2]

    def state(self, row: int = -1) -> State:
        """State at a row, from which navigation can go on; the last one by default."""
        return State(
            lat=self.lat[..., row],
            lon=self.lon[..., row],
            alt=self.alt[..., row],
            v_eb_n=self.v_eb_n[..., row, :],
            C_b_n=self.C_b_n[..., row, :, :],
        )

    def to_frame(self) -> "DataFrame":
        """Table of one run: index ``time``, s, columns `TRAJECTORY_COLUMNS`, rad, m and m/s."""
        import pandas as pd

        if self.lat.ndim != 1:
            raise ValueError(f"only one run makes a table, got runs of shape {self.lat.shape[:-1]}")
        columns = (self.lat, self.lon, self.alt, *self.v_eb_n.T, *self.heading_pitch_roll)
        table = np.stack(columns).T  # column by column, as pandas stores it
        return pd.DataFrame(table, index=pd.Index(self.time, name="time"), columns=list(TRAJECTORY_COLUMNS), copy=False)

    def _rotation(self) -> Rotation:
        if self.quaternion is None:
            raise ValueError("the attitude was not kept: navigate with `keep_attitude=True`")
        return Rotation.from_quat(self.quaternion.reshape(-1, 4))
