"""The paper's own estimate of its errors, (32)-(35), against error dynamics that have the Earth's rotation in them.

Two things bend the straight lines that the method draws through the velocity: a gyro bias that is left over, and an
error of the attitude at the start. `slope_error` navigates either to first order. As angles:

- a bias B along a level axis of the turn: ``B (t + t_turn) / 2``, the distance of the middles of the dwells; (33) has
  ``B t / 2``;
- a start that is wrong by gamma: ``Omega x gamma`` times that distance, which (34) leaves out. It exceeds the Schuler
  term, which (35) keeps, in every test shorter than ``2 Omega / omega_Sh^2``, 95 s.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.claims import Proof
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, normal_gravity, radius_meridian, radius_transverse
from fogkit.reproduction.klimkovich import paper
from fogkit.rotation import dcm_from_rotvec, skew
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import ARCSEC, DEG

if TYPE_CHECKING:
    from sympy import Expr

Array = NDArray[np.float64]

LATITUDE = 53.9 * DEG
"""Of Minsk, where the author works; the paper does not say where it calibrates."""

_STEP = 0.02  # s; fourth order: 1e-6 of the effect of a bias that turns at 2 Hz


def angle_of_bias(duration: float = paper.TEST_DURATION, bias: float = paper.GYRO_BIAS_LEFT) -> float:
    """(33) as printed, rad."""
    return bias * duration / 2


def angle_of_start(
    duration: float = paper.TEST_DURATION,
    start: float = paper.START_ANGLE,
    frequency: float = paper.SCHULER_FREQUENCY,
) -> float:
    """(35) as printed, rad."""
    return start * (frequency * duration) ** 2 / 2


def schuler_frequencies(lat: ArrayLike) -> Array:
    """Schuler frequency with the radius of the meridian and with the transverse one, rad/s, shape (..., 2)."""
    radii = np.stack([radius_meridian(lat), radius_transverse(lat)], axis=-1)
    return np.sqrt(normal_gravity(lat)[..., np.newaxis] / radii)


def longest_test_of_earth_rate(frequency: float | None = None) -> float:
    """Duration, s, below which an angle error drifts more by the Earth rate than by Schuler's oscillation."""
    return 2 * EARTH_RATE / (frequency or float(schuler_frequencies(LATITUDE).mean())) ** 2


# By symbols


def line_slope(velocity: Expr, time: Expr, start: Expr, end: Expr) -> Expr:
    """Slope of the straight line of least squares through a velocity over a dwell, in continuous time."""
    import sympy as sp

    middle = (start + end) / 2
    return sp.simplify(sp.integrate((time - middle) * velocity, (time, start, end)) * 12 / (end - start) ** 3)


@cache
def bias_equations() -> dict[str, tuple[Expr, Expr, Expr | None]]:
    """(32) and (33): what follows for a bias along a level axis that keeps its direction, the print, the correction."""
    import sympy as sp

    g, B, t, s, dwell, turn = sp.symbols("g_0 B t s t_1 t_turn", positive=True)
    tilt = sp.integrate(B, (s, 0, s))
    velocity = sp.integrate(g * tilt, (s, 0, t))
    second = dwell + turn
    change = line_slope(velocity, t, second, second + dwell) - line_slope(velocity, t, 0, dwell)
    duration = 2 * dwell + turn
    return {
        "eq32": (velocity, g * B * t**2 / 2, None),
        "eq33": (sp.expand(change / g), B * duration / 2, B * (duration + turn) / 2),
    }


def bias_proof(name: str) -> Proof:
    """Proof of (32) or (33)."""
    import sympy as sp

    derived, printed, corrected = bias_equations()[name]
    holds = [None if side is None else sp.expand(derived - side) == 0 for side in (printed, corrected)]
    return Proof(printed=holds[0], corrected=holds[1])


def eq35_proof() -> Proof:
    """Whether the first term of (34) that depends on time is that of (35), and whether it is with a minus sign."""
    import sympy as sp

    start, w, t = sp.symbols("gamma_0 omega t", positive=True)
    term = sp.series(start * sp.cos(w * t), t, 0, 3).removeO() - start
    printed = start * (w * t) ** 2 / 2
    return Proof(printed=sp.expand(term - printed) == 0, corrected=sp.expand(term + printed) == 0)


# By the error dynamics


def slope_error(
    test: TurnTest,
    *,
    lat: float = LATITUDE,
    start: ArrayLike = (0.0, 0.0, 0.0),
    gyro_bias: ArrayLike = (0.0, 0.0, 0.0),
    earth_rate: bool = True,
    schuler: bool = True,
    degree: int = 1,
) -> Array:
    """Change of slope over a test that an error of the start and a gyro bias make, as an angle.

    Parameters
    ----------
    test : TurnTest
        Dwells and a steady turn.
    lat : float, optional
        Latitude, rad.
    start : array_like, shape (3,), optional
        Error of the attitude at the start, rotation vector in n, rad.
    gyro_bias : array_like, shape (3,), optional
        What the compensated gyros have too much, rad/s, body axes.
    earth_rate, schuler : bool, optional
        Whether the Earth turns, and whether the velocity turns the level.
    degree : {1, 2}, optional
        Degree of the polynomial through the velocity of a dwell. With 2 the slopes are those at the end of the first
        dwell and at the beginning of the last.

    Returns
    -------
    ndarray, shape (2,)
        East and north, rad: change of slope over gravity.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Notes
    -----
    ``theta' = C b - omega_in x theta - d(omega_in)`` and ``v' = theta x (0, 0, g)``, by Runge and Kutta; the velocity
    is set to zero at the end of the turn, as the paper does. The heading that the velocity adds is left out: it would
    act on the level by the Earth rate, in second order.
    """
    degree = checks.integer("degree", degree, minimum=1)
    gravity = float(normal_gravity(lat))
    turned = -skew(earth_rate_n(lat)) if earth_rate else np.zeros((3, 3))
    A = np.zeros((5, 5))  # theta, then velocity east and north
    A[:3, :3] = turned
    A[3, 1], A[4, 0] = gravity, -gravity
    if schuler:
        A[0, 4], A[1, 3] = 1 / radius_meridian(lat), -1 / radius_transverse(lat)
    bias = checks.finite_array("gyro_bias", gyro_bias, shape=(3,))
    state = np.concatenate([checks.finite_array("start", start, shape=(3,)), np.zeros(2)])
    slopes = []
    for part, (begin, end) in enumerate(test.dwells):
        if part:
            state = _propagate(A, bias, test, state, (test.dwells[0][1], begin))[1][-1]
            state[3:] = 0
        times, states = _propagate(A, bias, test, state, (begin, end))
        state = states[-1]
        where = (end, begin)[part] if degree > 1 else begin
        slopes.append(np.polyfit(times - where, states[:, 3:], degree)[-2])
    return (slopes[1] - slopes[0]) / gravity


def _propagate(A: Array, bias: Array, test: TurnTest, state: Array, span: tuple[float, float]) -> tuple[Array, Array]:
    """Times and states over a span of time, by the classical method of fourth order."""
    steps = max(1, round((span[1] - span[0]) / _STEP))
    h = (span[1] - span[0]) / steps
    halves = span[0] + h / 2 * np.arange(2 * steps + 1)
    angle = np.interp(halves, [test.dwells[0][1], test.dwells[1][0]], [0, test.angle])
    drive = np.zeros((len(halves), 5))
    drive[:, :3] = test.C_b_n @ dcm_from_rotvec(test.axis * angle[:, np.newaxis]) @ bias
    states = np.empty((steps + 1, 5))
    states[0] = state
    for i in range(steps):
        x, (d0, d1, d2) = states[i], drive[2 * i : 2 * i + 3]
        k1 = A @ x + d0
        k2 = A @ (x + h / 2 * k1) + d1
        k3 = A @ (x + h / 2 * k2) + d1
        states[i + 1] = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + A @ (x + h * k3) + d2)
    return halves[::2], states


def test_of_the_estimate(turn_duration: float = 15.0) -> TurnTest:
    """The paper's first test in its 35 s, of which the paper does not say how long the turn is."""
    dwell = (paper.TEST_DURATION - turn_duration) / 2
    return nine_tests(dwell=dwell, turn_duration=turn_duration)[0]


test_of_the_estimate.__test__ = False  # no test of pytest's


@cache
def start_effects(turn_duration: float = 15.0) -> dict[str, dict[str, float]]:
    """Change of slope over the first test, arcsec, that a start wrong by 0.1 deg about each axis makes.

    Returns
    -------
    dict
        "east", "north", "up" to the size of the change with the Earth rate alone, with the Schuler term alone, and
        with both.
    """
    test = test_of_the_estimate(turn_duration)
    switches = {"earth": (True, False), "schuler": (False, True), "both": (True, True)}
    return {
        axis: {
            name: float(np.linalg.norm(slope_error(test, start=start, earth_rate=earth, schuler=schuler))) / ARCSEC
            for name, (earth, schuler) in switches.items()
        }
        for axis, start in zip(("east", "north", "up"), paper.START_ANGLE * np.eye(3), strict=True)
    }


@cache
def bias_effects(turn_duration: float = 15.0) -> dict[str, float]:
    """Change of slope over the first test, arcsec, by the bias of (33) in each gyro; x is the axis of the turn."""
    test = test_of_the_estimate(turn_duration)
    return {
        gyro: float(np.linalg.norm(slope_error(test, gyro_bias=bias))) / ARCSEC
        for gyro, bias in zip("xyz", paper.GYRO_BIAS_LEFT * np.eye(3), strict=True)
    }


@cache
def degrees_compared(turn_duration: float = 15.0) -> dict[int, float]:
    """Degree of the polynomial to the change of slope, arcsec, by the bias of (33) along the axis of the turn."""
    test = test_of_the_estimate(turn_duration)
    bias = (paper.GYRO_BIAS_LEFT, 0, 0)
    return {d: float(np.linalg.norm(slope_error(test, gyro_bias=bias, degree=d))) / ARCSEC for d in (1, 2)}
