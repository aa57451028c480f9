"""A three-axis rate table: outer axis 3 (vertical), middle axis 2 (east at zero), inner axis 1, and its errors.

At zero readings the platform stands along east, north, up. The scheme is that of volynskii, Fig. 4.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.earth import earth_rate_n
from fogkit.rotation import dcm_from_rotvec

AXES = ("outer", "middle", "inner")
GEOMETRY = (
    "level_east", "level_north", "azimuth_error", "outer_middle", "middle_inner",
    "mounting_x", "mounting_y", "mounting_z",
)  # fmt: skip
"""Names of the angular errors, in the order of `RateTable.geometry`."""


@dataclass(frozen=True, kw_only=True)
class RateTable:
    """Rate table at a place on the Earth.

    Parameters
    ----------
    latitude : float
        Geodetic latitude, rad.
    level_east, level_north : float, optional
        Tilt of the base about east and north, rad.
    azimuth_error : float, optional
        Turn of the base about up, rad, counter-clockwise positive.
    outer_middle, middle_inner : float, optional
        Non-orthogonality: tilt of the middle axis against the plane normal to the outer one, and of the inner one
        against that normal to the middle one, rad.
    mounting : array_like, shape (3,), optional
        Small rotation of the case against the platform, rad.
    readout_noise : float, optional
        Standard deviation of one reading of a table angle, rad.
    latch_time_error : float, optional
        Standard deviation of the time at which a table angle is latched, s.
    rate_stability : float, optional
        Standard deviation of a commanded rate, relative to it.

    Raises
    ------
    ValueError
        If a number is not finite, a deviation negative, or the latitude beyond a pole.
    """

    latitude: float
    level_east: float = 0.0
    level_north: float = 0.0
    azimuth_error: float = 0.0
    outer_middle: float = 0.0
    middle_inner: float = 0.0
    mounting: ArrayLike = field(default=(0.0, 0.0, 0.0))
    readout_noise: float = 0.0
    latch_time_error: float = 0.0
    rate_stability: float = 0.0

    def __post_init__(self) -> None:
        checks.in_closed_interval("latitude", self.latitude, -np.pi / 2, np.pi / 2, "rad")
        for name in GEOMETRY[:5]:
            checks.in_open_interval(name, getattr(self, name), -0.5, 0.5, "rad")
        mounting = checks.finite_array("mounting", self.mounting, shape=(3,))
        object.__setattr__(self, "mounting", tuple(mounting.tolist()))
        for name in ("readout_noise", "latch_time_error", "rate_stability"):
            checks.non_negative(name, getattr(self, name))

    @property
    def geometry(self) -> NDArray[np.float64]:
        """Angular errors in the order of `GEOMETRY`, rad, shape (8,)."""
        return np.array([*(getattr(self, name) for name in GEOMETRY[:5]), *self.mounting])

    def with_geometry(self, errors: ArrayLike) -> "RateTable":
        """Same table with other angular errors, in the order of `GEOMETRY`, rad, shape (8,)."""
        errors = checks.finite_array("errors", errors, shape=(len(GEOMETRY),))
        return replace(self, **dict(zip(GEOMETRY[:5], errors[:5].tolist(), strict=True)), mounting=errors[5:])

    @property
    def omega_ie_n(self) -> NDArray[np.float64]:
        """Rotation of the Earth in east, north, up, rad/s, shape (3,)."""
        return earth_rate_n(self.latitude)

    def C_0_n(self, outer: ArrayLike, middle: ArrayLike, inner: ArrayLike) -> NDArray[np.float64]:
        """Direction cosines from case to east, north, up.

        Parameters
        ----------
        outer, middle, inner : array_like, shape (...,)
            Angles of the three axes, rad.

        Returns
        -------
        ndarray, shape (..., 3, 3)
            ``v_n = C_0_n @ v_0``.
        """
        base, gimbal, platform = self._fixed
        turns = [_turn(axis, angle) for axis, angle in ((2, outer), (0, middle), (2, inner))]
        return base @ turns[0] @ gimbal @ turns[1] @ platform[0] @ turns[2] @ platform[1]

    def axis_in_case(self, turning: str, middle: ArrayLike, inner: ArrayLike) -> NDArray[np.float64]:
        """Direction of a turning axis in axes of the case, which does not change while only that axis turns.

        Parameters
        ----------
        turning : {"outer", "middle", "inner"}
            The axis.
        middle, inner : array_like, shape (...,)
            Angles of the axes inside, rad.

        Returns
        -------
        ndarray, shape (..., 3)
            Unit vector.
        """
        checks.option("turning", turning, AXES)
        _, gimbal, platform = self._fixed
        inward = np.eye(3)
        if turning == "outer":
            inward = gimbal @ _turn(0, middle) @ platform[0] @ _turn(2, inner)
        elif turning == "middle":
            inward = platform[0] @ _turn(2, inner)
        axis = np.array([1.0, 0.0, 0.0]) if turning == "middle" else np.array([0.0, 0.0, 1.0])
        return np.einsum("...ji,j->...i", inward @ platform[1], axis)

    @cached_property
    def _fixed(self):
        """Rotations of base, middle axis, inner axis and case that the errors make."""
        base = dcm_from_rotvec([self.level_east, self.level_north, self.azimuth_error])
        gimbal = dcm_from_rotvec([0.0, self.outer_middle, 0.0])
        inner = dcm_from_rotvec([0.0, self.middle_inner, 0.0])
        return base, gimbal, (inner, dcm_from_rotvec(self.mounting))


def _turn(axis: int, angle: ArrayLike) -> NDArray[np.float64]:
    """Rotation by an angle about a coordinate axis, shape (..., 3, 3)."""
    s, c = np.sin(angle), np.cos(angle)
    second, third = (axis + 1) % 3, (axis + 2) % 3
    C = np.zeros((*np.shape(angle), 3, 3))
    C[..., axis, axis] = 1
    C[..., second, second] = C[..., third, third] = c
    C[..., third, second], C[..., second, third] = s, -s
    return C
