"""True motion of a unit on a rough turntable during one test: dwell, turn, dwell, in closed form.

Nothing is integrated: the profile of the turn is a polynomial in pieces, the wobble of the axis a sum of harmonics of
the angle, and the answer of the absorbers to both is known. Attitude, rate and specific force at any time are exact for
that motion, and so the increments are as good as the quadrature that sums them.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.constants import STANDARD_GRAVITY
from fogkit.stand.turn_tests import TurnTest

Array = NDArray[np.float64]

LARGEST_TURN = 0.5
"""Largest wobble and sag, rad: their series are cut for it, and rougher is no table."""

ORDERS = 60
"""Highest order of a wobble."""

QUADRATURE = ((3, 0.15), (5, 1.0))
"""Points of the Gauss-Legendre quadratures, and the phase, rad, of the fastest part of the motion that one interval may
span. The integral over it is then wrong by 1e-12 and 4e-13 of that part's amplitude, ``x**(2n+1) n!**4 / ((2n+1)
(2n)!**3)`` for a phase x and n points."""

_RULES = tuple((phase, *np.polynomial.legendre.leggauss(count)) for count, phase in QUADRATURE)

SILENCE = 1e-18
"""Lag of the absorber, rad, below which the unit rests."""


@dataclass(frozen=True, kw_only=True)
class Harmonic:
    """One part of the wobble: ``amplitude * cos(order * angle + phase)`` about three axes that do not turn.

    Parameters
    ----------
    order : int
        Periods in one turn of the table.
    amplitude : array_like, shape (3,)
        About the level direction across the axis, about the third one, and about the axis itself, rad. The last one is
        an error of the angle. The level direction is up x axis, or north x axis if the axis is upright to 0.1 rad.
    phase : array_like, shape (3,), optional
        Phases of the three, rad.
    """

    order: int
    amplitude: ArrayLike
    phase: ArrayLike = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        order = checks.integer("order", self.order, minimum=1)
        object.__setattr__(self, "order", int(checks.in_closed_interval("order", order, 1, ORDERS)))
        for name in ("amplitude", "phase"):
            values = checks.finite_array(name, getattr(self, name), shape=(3,))
            object.__setattr__(self, name, tuple(values.tolist()))


@dataclass(frozen=True, kw_only=True)
class Absorber:
    """Shock absorbers between the case and the block of sensors: they sag under gravity and ring after a turn.

    Parameters
    ----------
    sag : array_like, shape (3, 3), optional
        Small rotation of the sensors against the case, case axes, that 1 g (9.80665 m/s^2) upwards along x, y, z makes,
        column by column, rad. It follows gravity at once; other accelerations do not move it.
    frequency : float, optional
        Natural frequency without damping, Hz.
    damping : float, optional
        Damping ratio, in [0, 1).
    coupling : array_like, shape (3, 3), optional
        Rotation vector, case axes, by which the sensors lag for each unit of lag about the axis of the turn: the
        identity for absorbers that hold the block in its centre of mass; 0 for ones that do not ring.

    Notes
    -----
    The lag r about the axis obeys ``r'' + 2 d w r' + w^2 r = -phi''`` with ``w = 2 pi frequency`` and damping ratio d:
    the block keeps behind while the case is accelerated.
    """

    sag: ArrayLike = field(default=((0.0,) * 3,) * 3)
    frequency: float = 15.0
    damping: float = 0.1
    coupling: ArrayLike = field(default=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))

    def __post_init__(self) -> None:
        for name in ("sag", "coupling"):
            values = checks.finite_array(name, getattr(self, name), shape=(3, 3))
            object.__setattr__(self, name, tuple(map(tuple, values.tolist())))
        object.__setattr__(self, "frequency", checks.positive("frequency", self.frequency, "Hz"))
        damping = checks.in_closed_interval("damping", self.damping, 0.0, 0.99, fix="Absorbers that ring are weaker.")
        object.__setattr__(self, "damping", damping)


@dataclass(frozen=True, kw_only=True, eq=False)
class TurnMotion:
    """Motion of the unit in one test, as `fogkit.stand.rough_table.RoughTable.motions` makes it.

    Parameters
    ----------
    test : TurnTest
        What was commanded.
    C_case_n : array_like, shape (3, 3)
        Attitude of the case in the first dwell without wobble.
    axis : array_like, shape (3,)
        Axis of the turn, case axes; of any length.
    angle : float
        Angle of the turn, rad, reached exactly but for the wobble.
    omega_ie_n : array_like, shape (3,)
        Rotation of the Earth, east, north, up, rad/s.
    gravity : float
        Gravity along the plumb line, m/s^2, the same everywhere.
    ramp : float, optional
        Time in which the rate rises to its constant value, and falls, s.
    wobble : tuple of Harmonic, optional
        Of the turn angle from the beginning of the test, about directions of the axis as it turns positively.
    absorber : Absorber, optional
        None for a block that is fixed in the case.
    offset : array_like, shape (3,), optional
        Reference point of the unit against a fixed point of the axis, case axes, m.

    Raises
    ------
    ValueError
        If the ramps are longer than the turn, the wobble or the sag is beyond `LARGEST_TURN`, or an argument is not
        what it must be.

    Notes
    -----
    [1] ``C_b_n = C_case_n R(w) R(u phi) R(s)``: wobble w in axes that do not turn, turn phi about u, and sag and lag
    s = ``sag @ up_case * gravity / 9.80665 + coupling @ u * r``. R(v) is the rotation by the vector v.

    [2] Rate of the case against the Earth: ``R(u phi)^T rate(w, w') + u phi'``; its derivative follows in closed form.

    [3] ``rate(w, w') = w' - (1-cos|w|)/|w|^2 w x w' + (|w|-sin|w|)/|w|^3 w x (w x w')``, the rate of R(w) in its own
    axes.

    [4] Specific force at the reference point l, case axes, with the case's rate o and the Earth's W:
    ``o' x l + (o + 2 W) x (o x l) + gravity * up``. Left out are the change of gravity over the circle that the point
    moves on (3e-6 of its radius, m/s^2), that of the plumb line, radius over Earth radius (0.008 arcsec for 0.25 m),
    and the transport rate, which is the same thing; so east, north and up are those of the axis.

    [5] ``omega_ib_b = R(s)^T (o + W) + rate(s, s')``, and the specific force turns with R(s)^T. The block turns about
    the reference point.

    The rate rises as the smooth step ``x^3 (10 - 15 x + 6 x^2)``: acceleration and jerk are continuous, and 0 at both
    ends of a ramp. Before the test and after it the unit stays where it is, the ringing fading away.
    """

    test: TurnTest
    C_case_n: ArrayLike
    axis: ArrayLike
    angle: float
    omega_ie_n: ArrayLike
    gravity: float
    ramp: float = 0.5
    wobble: tuple[Harmonic, ...] = ()
    absorber: Absorber | None = None
    offset: ArrayLike = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        checks.instance("test", self.test, TurnTest)
        object.__setattr__(self, "C_case_n", checks.rotation_matrix("C_case_n", self.C_case_n).copy())
        axis = checks.finite_array("axis", self.axis, shape=(3,))
        length = np.linalg.norm(axis)
        if not length > 0:
            raise ValueError(f"`axis` must have a direction, got {axis.tolist()}")
        object.__setattr__(self, "axis", axis / length)
        object.__setattr__(self, "angle", checks.finite("angle", self.angle, "rad"))
        for name in ("omega_ie_n", "offset"):
            object.__setattr__(self, name, checks.finite_array(name, getattr(self, name), shape=(3,)).copy())
        object.__setattr__(self, "gravity", checks.positive("gravity", self.gravity, "m/s^2"))
        object.__setattr__(self, "ramp", checks.positive("ramp", self.ramp, "s"))
        if 2 * self.ramp > self.test.turn_duration:
            raise ValueError(
                f"`ramp` must be at most half of the turn, {self.test.turn_duration / 2:g} s in test "
                f"{self.test.label!r}, got {self.ramp:g} s"
            )
        object.__setattr__(self, "wobble", tuple(self.wobble))
        for harmonic in self.wobble:
            checks.instance("wobble", harmonic, Harmonic)
        if self.absorber is not None:
            checks.instance("absorber", self.absorber, Absorber)
        self._require_small()

    @property
    def dwells(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Beginning and end of both dwells as commanded, s; the unit may ring in the second."""
        return self.test.dwells

    @property
    def duration(self) -> float:
        """Duration of the test, s."""
        return self.test.duration

    @property
    def rate(self) -> float:
        """Constant rate between the ramps, rad/s."""
        return self.angle / (self.test.turn_duration - self.ramp)

    def C_b_n(self, time: ArrayLike) -> Array:
        """Attitude at times of shape (...,), s from the beginning: shape (..., 3, 3)."""
        return self._evaluate(time)[0]

    def omega_ib_b(self, time: ArrayLike) -> Array:
        """Rate against inertial space in body axes, rad/s, shape (..., 3)."""
        return self._evaluate(time)[1][..., 0, :]

    def f_ib_b(self, time: ArrayLike) -> Array:
        """Specific force at the reference point in body axes, m/s^2, shape (..., 3)."""
        return self._evaluate(time)[1][..., 1, :]

    def position(self, time: ArrayLike) -> Array:
        """Reference point from the point of the axis, east, north, up, m, shape (..., 3)."""
        return self._evaluate(time)[1][..., 2, :]

    def velocity(self, time: ArrayLike) -> Array:
        """Velocity of the reference point against the Earth, ``v_eb_n``, m/s, shape (..., 3)."""
        return self._evaluate(time)[1][..., 3, :]

    def turned(self, time: ArrayLike) -> Array:
        """Angle of the turn so far without wobble, rad, shape (...,)."""
        return self._evaluate(time)[2][..., 0]

    def lag(self, time: ArrayLike) -> Array:
        """How far the sensors lag in their absorbers about the axis of the turn, rad, shape (...,)."""
        return self._evaluate(time)[2][..., 1]

    def increments(self, rate: float, delay: float = 0.0, *, products: bool = False) -> Array:
        """Integrals over each step of the test.

        Parameters
        ----------
        rate : float
            Steps per second; the duration of the test must be a whole number of steps.
        delay : float, optional
            How much earlier the steps begin, s.
        products : bool, optional
            Whether to add what the size effect needs.

        Returns
        -------
        ndarray, shape (n, 6) or (n, 15)
            Integrals of the rate, rad, and of the specific force, m/s; with `products` those of the products of the
            rates xx, yy, zz, xy, xz, yz, rad^2/s, and the change of the rate, rad/s.

        Notes
        -----
        Gauss-Legendre quadrature (`QUADRATURE`), cut where the profile changes and where the step is long for the
        fastest part. Against twenty points on a fifth of an interval the sums differ by rounding only: by less than
        1e-15 rad and 1e-13 m/s in a step, the latter that of the time of its ends, times gravity.
        """
        from fogkit.stand import _kernels

        rate = checks.positive("rate", rate, "Hz")
        count = round(self.duration * rate)
        if count < 1 or abs(count - self.duration * rate) > 1e-6:
            raise ValueError(
                f"`rate` must give a whole number of steps, got {rate:g} Hz in {self.duration:g} s of test "
                f"{self.test.label!r}"
            )
        sums = np.zeros((count, 15 if products else 6))
        phase, points, weights = next((rule for rule in _RULES if rule[0] * rate > self._fastest), _RULES[-1])
        quadrature = (0.5 + 0.5 * points, 0.5 * weights, phase / self._fastest)
        delay = checks.finite("delay", delay, "s")
        _kernels.increments(*self.model, self._still, -delay, 1 / rate, *quadrature, sums)
        return sums

    @cached_property
    def model(self) -> tuple:
        """Motion as the compiled functions take it: the arguments of `fogkit.stand._kernels.evaluate`."""
        starts, angles = self._profile
        decay, frequency, sag, lag_axis = 0.0, 0.0, np.zeros((3, 3)), np.zeros(3)
        lags = np.zeros((5, 9))
        if self.absorber is not None:
            natural = 2 * np.pi * self.absorber.frequency
            decay, frequency = natural * self.absorber.damping, natural * np.sqrt(1 - self.absorber.damping**2)
            lags = _lags(starts, angles, decay, frequency)
            sag = np.array(self.absorber.sag) * (self.gravity / STANDARD_GRAVITY)
            lag_axis = np.array(self.absorber.coupling) @ self.axis
        motion = (self.C_case_n, self.axis, self.offset, self._wobble_table, starts, angles, lags)
        return (*motion, float(decay), float(frequency), sag, lag_axis, self.omega_ie_n, self.gravity)

    def _evaluate(self, time: ArrayLike) -> tuple[Array, Array, Array]:
        """Attitude, vectors and scalars of the kernel at times of any shape."""
        from fogkit.stand import _kernels

        time = checks.finite_array("time", time)
        times = np.array(time, order="C").reshape(-1)
        outputs = [np.empty((times.size, *shape)) for shape in ((3, 3), (4, 3), (2,))]
        _kernels.evaluate(*self.model, times, *outputs)
        return tuple(output.reshape(*time.shape, *output.shape[1:]) for output in outputs)

    @property
    def _profile(self) -> tuple[Array, Array]:
        """Starts of ramp, steady turn, ramp and rest, and polynomials of the angle: rest, those, rest."""
        ramp, rate, (turn, end) = self.ramp, self.rate, (self.dwells[0][1], self.dwells[1][0])
        starts = np.array([turn, turn + ramp, end - ramp, end])
        smooth = np.array([0, 0, 0, 0, 2.5, -3.0, 1.0]) * rate * ramp / ramp ** np.arange(7)  # integral of the step
        angles = np.zeros((5, 7))
        angles[1] = smooth
        angles[2, :2] = 0.5 * rate * ramp, rate
        angles[3] = -smooth
        angles[3, :2] += self.angle - 0.5 * rate * ramp, rate
        angles[4, 0] = self.angle
        return starts, angles

    @property
    def _wobble_table(self) -> Array:
        """Amplitudes of cosine and sine of orders 0 to the highest, case axes before the turn, shape (2, k+1, 3)."""
        if not self.wobble:
            return np.zeros((2, 0, 3))
        along = self.C_case_n @ self.axis
        level = np.cross([0.0, 0.0, 1.0], along)
        if np.linalg.norm(level) < 0.1:
            level = np.cross([0.0, 1.0, 0.0], along)
        level /= np.linalg.norm(level)
        directions = np.stack([level, np.cross(along, level), along]) @ self.C_case_n  # rows, case axes
        table = np.zeros((2, 1 + max(harmonic.order for harmonic in self.wobble), 3))
        for harmonic in self.wobble:
            amplitude, phase = np.array(harmonic.amplitude), np.array(harmonic.phase)
            table[0, harmonic.order] += (amplitude * np.cos(phase)) @ directions
            table[1, harmonic.order] -= (amplitude * np.sin(phase)) @ directions
        return table

    @property
    def _fastest(self) -> float:
        """Angular frequency of the fastest part of the motion, rad/s."""
        absorber = self.absorber
        ringing = 0.0 if absorber is None else 2 * np.pi * absorber.frequency
        orders = max(self.model[3].shape[1], 2)
        return max(abs(self.rate) * orders, 4 / self.ramp, ringing)

    @property
    def _still(self) -> float:
        """Time from which the unit rests again, s."""
        *_, starts, _, lags, decay, frequency, _, _, _, _ = self.model
        amplitude = np.hypot(*lags[-1, 7:])
        if frequency == 0 or amplitude <= SILENCE:
            return float(starts[-1])
        return float(starts[-1] + np.log(amplitude / SILENCE) / decay) if decay else np.inf

    def _require_small(self) -> None:
        """``ValueError`` for a wobble or a sag beyond what the series are cut for."""
        wobble = sum(np.linalg.norm(harmonic.amplitude) for harmonic in self.wobble)
        sag = 0.0
        if self.absorber is not None:
            swing = np.linalg.norm(self.absorber.coupling, 2) * 2 * 1.875 * abs(self.rate) / self.ramp
            swing /= (2 * np.pi * self.absorber.frequency) ** 2
            sag = np.linalg.norm(self.absorber.sag, 2) * self.gravity / STANDARD_GRAVITY + swing
        for name, size in (("wobble", wobble), ("absorber", sag)):
            if size > LARGEST_TURN:
                raise ValueError(
                    f"`{name}` must turn the unit by less than {LARGEST_TURN} rad, got up to {size:.3g} rad"
                )


def _lags(starts: Array, angles: Array, decay: float, frequency: float) -> Array:
    """Lag of an absorber in each piece: a polynomial, and what rings on, so that lag and its derivative go on smoothly.

    With the acceleration of a piece a polynomial, the polynomial part of the lag is one of the same degree; its
    coefficients follow from the highest down.
    """
    square = decay**2 + frequency**2
    lags = np.zeros((len(angles), 9))
    powers = np.arange(7)
    value = slope = 0.0  # at the beginning of the piece
    for piece in range(1, len(angles)):
        forcing = np.zeros(9)
        forcing[:5] = -(powers[2:] * powers[1:-1] * angles[piece, 2:])
        steady = np.zeros(9)
        for j in range(6, -1, -1):
            later = 2 * decay * (j + 1) * steady[j + 1] + (j + 1) * (j + 2) * steady[j + 2]
            steady[j] = (forcing[j] - later) / square
        cosine = value - steady[0]
        sine = (slope - steady[1] + decay * cosine) / frequency
        lags[piece] = *steady[:7], cosine, sine
        if piece < len(angles) - 1:
            tau = starts[piece] - starts[piece - 1]
            fade = np.exp(-decay * tau)
            c, s = fade * np.cos(frequency * tau), fade * np.sin(frequency * tau)
            value = np.polyval(steady[6::-1], tau) + cosine * c + sine * s
            slope = np.polyval((powers[1:] * steady[1:7])[::-1], tau)
            slope += (sine * frequency - decay * cosine) * c - (cosine * frequency + decay * sine) * s
    return lags
