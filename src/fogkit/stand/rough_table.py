"""A rough turntable of two axes, good to a fraction of a degree, and how it carries out dwells and turns.

At zero angles the outer axis points east, the inner one up, and the unit stands along east, north, up on it: the table
of the plan recovered from klimkovich. A test that this table can not command, for its start or for its axis, is carried
out all the same, as on some fixture: it gets the errors that are drawn, but none of the geometry of the two axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.turn_motion import Absorber, Harmonic, TurnMotion
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import DEG

Array = NDArray[np.float64]

REACHED = 1e-9
"""Largest entry, of a direction cosine, by which a commanded attitude or axis may miss what the table can reach."""

_SMALL = ("level_east", "level_north", "azimuth_error", "non_orthogonality")
_DRAWN = ("start_error", "axis_error", "angle_error")


@dataclass(frozen=True, kw_only=True)
class RoughTable:
    """Rough turntable at a place on the Earth.

    Parameters
    ----------
    latitude : float
        Geodetic latitude, rad.
    altitude : float, optional
        Height above the ellipsoid, m.
    gravity : float, optional
        Gravity, m/s^2; by default normal gravity at the place (`dataclasses.replace` of the place keeps it).
    level_east, level_north, azimuth_error : float, optional
        Small rotation of the base about east, north and up, rad: one rotation vector.
    non_orthogonality : float, optional
        Angle by which the inner axis leans towards the outer one in the plane of both, rad. It tilts the unit about the
        direction across both at every start, and the outer axis in the unit with it.
    start_error : float, optional
        Standard deviation of a rotation of the unit about each of its axes, drawn for each test, rad.
    axis_error : float, optional
        Standard deviation of the direction of the turn's axis in the unit, about both directions across it, drawn for
        each test, rad.
    angle_error : float, optional
        Standard deviation of the angle of the turn, drawn for each test, rad.
    wobble : sequence of Harmonic, optional
        Rotation-synchronous motion of the axis, the same in every turn, as a function of the angle of the table's axis
        that turns, or of the turn if it is none of them.
    absorber : Absorber, optional
        Shock absorbers of the sensors; none by default.
    offset : array_like, shape (3,), optional
        Reference point of the unit against the axes' crossing, in body axes, m.
    ramp : float, optional
        Duration of each ramp of the rate, s.

    Raises
    ------
    ValueError
        If a number is not finite, a deviation negative, the latitude beyond a pole, or an angle 0.5 rad or more.
    """

    latitude: float
    altitude: float = 0.0
    gravity: float = 0.0
    level_east: float = 0.0
    level_north: float = 0.0
    azimuth_error: float = 0.0
    non_orthogonality: float = 0.0
    start_error: float = 0.0
    axis_error: float = 0.0
    angle_error: float = 0.0
    wobble: Sequence[Harmonic] = ()
    absorber: Absorber | None = None
    offset: ArrayLike = field(default=(0.0, 0.0, 0.0))
    ramp: float = 0.5

    def __post_init__(self) -> None:
        fix = "Multiply degrees by `fogkit.units.DEG`."
        checks.in_closed_interval("latitude", self.latitude, -np.pi / 2, np.pi / 2, "rad", fix=fix)
        gravity = checks.non_negative("gravity", self.gravity, "m/s^2")
        object.__setattr__(self, "gravity", gravity or float(normal_gravity(self.latitude, self.altitude)))
        for name in _SMALL:
            checks.in_open_interval(name, getattr(self, name), -0.5, 0.5, "rad", fix=fix)
        for name in _DRAWN:
            checks.in_closed_interval(name, getattr(self, name), 0.0, 0.5, "rad", fix=fix)
        object.__setattr__(self, "wobble", tuple(self.wobble))
        for harmonic in self.wobble:
            checks.instance("wobble", harmonic, Harmonic)
        if self.absorber is not None:
            checks.instance("absorber", self.absorber, Absorber)
        offset = checks.finite_array("offset", self.offset, shape=(3,))
        object.__setattr__(self, "offset", tuple(offset.tolist()))
        checks.positive("ramp", self.ramp, "s")

    @classmethod
    def typical(cls, latitude: float, roughness: float = 1.0, **changes) -> Self:
        """A table good to a few tenths of a degree, or rougher or finer than that.

        Parameters
        ----------
        latitude : float
            Geodetic latitude, rad.
        roughness : float, optional
            Factor of every error, wobble, sag and ringing; at 0 the table has none and the unit turns about its
            reference point. The offset of 5 cm grows with it up to 1 only: it is no error.
        **changes
            Arguments of `RoughTable` to be set otherwise.

        Returns
        -------
        RoughTable
            At a roughness of 1: start 0.15 deg, axis and angle 0.2 deg, all standard deviations; non-orthogonality
            0.1 deg; base 0.1 deg; wobble 0.05 deg; sag about 0.1 deg/g; ringing at 15 Hz with damping 0.1. The ringing
            is scaled by the coupling of the absorber, not by its frequency.
        """
        size = checks.non_negative("roughness", roughness) * DEG
        wobble = (
            Harmonic(order=1, amplitude=(0.03 * size, 0.02 * size, 0.02 * size), phase=(0.3, 1.4, 2.5)),
            Harmonic(order=2, amplitude=(0.02 * size, 0.03 * size, 0.01 * size), phase=(-1.1, 0.6, -2.0)),
            Harmonic(order=5, amplitude=(0.005 * size, 0.005 * size, 0.005 * size), phase=(2.2, -0.7, 0.9)),
        )
        sag = 0.1 * size * np.array([[0.2, -0.8, 0.3], [0.8, -0.1, -0.4], [-0.3, 0.4, 0.2]])
        absorber = Absorber(sag=sag, frequency=15.0, damping=0.1, coupling=roughness * np.eye(3))
        errors = {
            "level_east": 0.1 * size,
            "level_north": -0.06 * size,
            "azimuth_error": 0.1 * size,
            "non_orthogonality": 0.1 * size,
            "start_error": 0.15 * size,
            "axis_error": 0.2 * size,
            "angle_error": 0.2 * size,
            "wobble": wobble if size else (),
            "absorber": absorber if size else None,
            "offset": min(roughness, 1.0) * np.array([0.03, -0.02, 0.035]),
        }
        return cls(latitude=latitude, **errors | changes)

    @property
    def omega_ie_n(self) -> Array:
        """Rotation of the Earth in east, north, up, rad/s, shape (3,)."""
        return earth_rate_n(self.latitude)

    def motions(self, plan: Sequence[TurnTest], rng: np.random.Generator | None = None) -> tuple[TurnMotion, ...]:
        """How the table carries out a plan.

        Parameters
        ----------
        plan : sequence of TurnTest
            What is commanded.
        rng : numpy.random.Generator, optional
            Source of the errors that are drawn: six numbers for each test whatever the deviations, so that tables of
            any roughness err alike. May be left out if the deviations are 0.

        Returns
        -------
        tuple of TurnMotion
            One for each test.

        Raises
        ------
        ValueError
            If the plan is empty, the ramps do not fit a turn, or errors are to be drawn without `rng`.
        """
        if isinstance(plan, TurnTest) or not len(plan):
            raise ValueError("`plan` must be at least one test, in a sequence")
        if rng is not None:
            checks.generator("rng", rng)
        elif any(getattr(self, name) for name in _DRAWN):
            raise ValueError("`rng` must be given for a table that errs by chance. Use `np.random.default_rng(seed)`.")
        return tuple(self._motion(checks.instance("plan", test, TurnTest), rng) for test in plan)

    def _motion(self, test: TurnTest, rng: np.random.Generator | None) -> TurnMotion:
        """Motion in one test."""
        draws = np.zeros(6) if rng is None else rng.standard_normal(6)
        C_case_n, axis, angle, sense = self._commanded(test)
        C_case_n = C_case_n @ dcm_from_rotvec(self.start_error * draws[:3])
        across = _across(axis)
        axis = dcm_from_rotvec(self.axis_error * draws[3:5] @ across) @ axis
        wobble = tuple(_from(harmonic, angle, sense) for harmonic in self.wobble)
        return TurnMotion(
            test=test,
            C_case_n=C_case_n,
            axis=axis,
            angle=test.angle + self.angle_error * draws[5],
            omega_ie_n=self.omega_ie_n,
            gravity=self.gravity,
            ramp=self.ramp,
            wobble=wobble,
            absorber=self.absorber,
            offset=self.offset,
        )

    def _commanded(self, test: TurnTest) -> tuple[Array, Array, float, int]:
        """Attitude and axis of the turn without what is drawn, and angle and sense of the table's axis that turns."""
        base = dcm_from_rotvec([self.level_east, self.level_north, self.azimuth_error])
        lean = dcm_from_rotvec([0.0, self.non_orthogonality, 0.0])
        C, axis = test.C_b_n, test.axis
        if abs(C[0, 2]) < REACHED:  # the unit's z axis, the inner one, lies across east
            outer, inner = float(np.arctan2(-C[1, 2], C[2, 2])), float(np.arctan2(-C[0, 1], C[0, 0]))
            C_inner = dcm_from_rotvec([0.0, 0.0, inner])
            C_case_n = base @ dcm_from_rotvec([outer, 0.0, 0.0]) @ lean @ C_inner
            for direction, angle, real in ((C[0], outer, (lean @ C_inner)[0]), ([0, 0, 1], inner, np.eye(3)[2])):
                if np.linalg.norm(np.cross(axis, direction)) < REACHED:
                    sense = 1 if axis @ direction > 0 else -1
                    return C_case_n, sense * real, angle, sense
        return base @ C, np.array(axis), 0.0, 1


def _across(axis: Array) -> Array:
    """Two unit vectors across an axis, rows; those of the other coordinates for a coordinate axis."""
    first = np.eye(3)[(int(np.argmax(np.abs(axis))) + 1) % 3]
    first = first - axis * (axis @ first)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _from(harmonic: Harmonic, angle: float, sense: int) -> Harmonic:
    """Harmonic of the turn, which begins at an angle of the table's axis and has the sense of that axis, or not.

    ``cos(k (angle + sense phi) + p) = cos(k phi + sense (k angle + p))``. With the axis its level direction is reversed
    too, but not the third one, the product of both.
    """
    phase = sense * (np.array(harmonic.phase) + harmonic.order * angle)
    return Harmonic(order=harmonic.order, amplitude=harmonic.amplitude * np.array([sense, 1, sense]), phase=phase)
