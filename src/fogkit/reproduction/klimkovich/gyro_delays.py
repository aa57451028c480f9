"""Gyros that are late by different times: how a turn about an axis that is not steady then turns the attitude.

A gyro that is late by tau reads ``omega(t - tau)``. At rest before and after a turn, its angle is complete in the end;
that is what the paper relies on. But the angle was counted in another attitude than it was made in. To first order the
computed attitude comes out turned by

``theta = - integral of C_b_n diag(tau) d(omega_ib_b)/dt``, [1]

about east, north, up. A delay common to all three only takes the time stamps back; the gyro of the axis of the turn is
therefore the clock, and what counts is how late the two others are against it. Three motions across the axis, with a
steady turn at the rate W through the angle Phi:

- the axis wobbles twice in a turn, by ``a cos 2 phi`` and ``b sin 2 phi`` about the level and the upright direction
  across it. Seen from the unit that is once in a turn, in step with how the two gyros change places:
  ``theta = (a + b) W Phi (tau_2 - tau_3) / 2``, [2], which grows with every turn; no other order does;
- the axis is steady but inclined to the gyro's: the cross rates come up late and go late, in two attitudes:
  ``theta = (C_after - C_before) diag(tau) omega_across``, [3], not more however long the turn;
- the Earth turns: ``theta = Phi tau u x omega_ie``, [4], with tau the mean of the two.

All are even in the sense of the turn, where what a scale factor error makes is odd.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.navigation import State, integrate_arrays
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.rotation import rotvec_from_dcm
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_motion import Harmonic, TurnMotion
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import DEG, MILLISECOND

if TYPE_CHECKING:
    from sympy import Expr

Array = NDArray[np.float64]

RATE = 1000.0
"""Samples per second of `simulated`; against 4000 the angle changes by less than 1e-4 of itself."""

WOBBLE = 0.05 * DEG
DELAY = 0.1 * MILLISECOND
"""Example: a wobble that nobody notices on a rough table, and gyro electronics that differ by a tenth of 1 ms."""


@cache
def by_symbols(order: int = 2) -> tuple[Expr, Expr]:
    """Rotation about the level and the upright direction that a wobble leaves after whole turns, by [1] in symbols.

    Parameters
    ----------
    order : int, optional
        Periods of the wobble in a turn.

    Returns
    -------
    tuple of Expr
        In the symbols ``a``, ``b`` (rad), ``W`` (rad/s), ``n`` (turns), ``tau_2`` and ``tau_3`` (s).
    """
    import sympy as sp

    order = checks.integer("order", order, minimum=1)
    a, b, W, phi, n, late = _symbols()
    turned = sp.Matrix([[sp.cos(phi), -sp.sin(phi)], [sp.sin(phi), sp.cos(phi)]])  # unit to space, across the axis
    axis = sp.Matrix([a * sp.cos(order * phi), b * sp.sin(order * phi)])
    rates = turned.T * W * sp.diff(axis, phi)
    wrong = turned * sp.diag(*(-tau for tau in late)) * sp.diff(rates, phi)  # per angle of the turn
    one = (sp.integrate(sp.expand(sp.expand_trig(part)), (phi, 0, 2 * sp.pi)) for part in wrong)
    return tuple(sp.factor(n * part) for part in one)


def in_closed_form() -> Expr:
    """[2] in the symbols of `by_symbols`, about the level direction."""
    import sympy as sp

    a, b, W, _, n, (tau_2, tau_3) = _symbols()
    return (a + b) * W * 2 * sp.pi * n * (tau_2 - tau_3) / 2


def _symbols() -> tuple:
    import sympy as sp

    a, b, W, phi = sp.symbols("a b W phi", positive=True)
    n = sp.symbols("n", integer=True, positive=True)
    return a, b, W, phi, n, sp.symbols("tau_2 tau_3", real=True)


def by_wobble(level: float, upright: float, rate: float, angle: float, difference: float) -> float:
    """Rotation [2] about the level direction across the axis, rad.

    Parameters
    ----------
    level, upright : float
        Amplitudes of a wobble ``a cos 2 phi``, ``b sin 2 phi``, rad, with phi = 0 where the second gyro
        lies level.
    rate, angle : float
        Of the turn, rad/s and rad.
    difference : float
        Delay of the second gyro across the axis less that of the third, s.
    """
    return (level + upright) * rate * angle * difference / 2


def by_inclined_axis(C_before: ArrayLike, C_after: ArrayLike, omega_b: ArrayLike, delay: ArrayLike) -> Array:
    """Rotation [3] that a steady axis beside a gyro's leaves, rad, east, north, up.

    Parameters
    ----------
    C_before, C_after : array_like, shape (3, 3)
        Attitudes in the dwells; more exactly, those at the mean angle of the ramp that follows or precedes.
    omega_b : array_like, shape (3,)
        Rate of the steady turn, rad/s.
    delay : array_like, shape (3,)
        Of the gyros, s.
    """
    omega, late = np.asarray(omega_b, dtype=float), np.asarray(delay, dtype=float)
    clock = omega**2 @ late / (omega @ omega)
    return (np.asarray(C_after) - np.asarray(C_before)) @ ((late - clock) * omega)


def by_earth_rate(axis_n: ArrayLike, angle: float, omega_ie_n: ArrayLike, mean_delay: float) -> Array:
    """Rotation [4] in a turn about a level axis, rad, east, north, up.

    Parameters
    ----------
    axis_n : array_like, shape (3,)
        Direction of the axis of the turn.
    angle : float
        Of the turn, rad.
    omega_ie_n : array_like, shape (3,)
        Rotation of the Earth, rad/s.
    mean_delay : float
        Mean delay of the two gyros across the axis less that of the gyro along it, s.
    """
    return angle * mean_delay * np.cross(axis_n, omega_ie_n)


def simulated(motion: TurnMotion, delay: ArrayLike, rate: float = RATE) -> Array:
    """Rotation of the attitude that is navigated with late gyros against that with punctual ones, at the end of a test.

    Parameters
    ----------
    motion : TurnMotion
        The test.
    delay : array_like, shape (3,)
        Of the gyros, s; their readings are exact but for it.
    rate : float, optional
        Samples per second.

    Returns
    -------
    ndarray, shape (3,)
        About east, north, up, rad.
    """
    ends = []
    for late in (delay, np.zeros(3)):
        (table,) = record(MeasurementUnit(gyros=Sensors(delay=late)), [motion], rate)
        values = table.to_numpy()
        start = State(lat=LATITUDE, C_b_n=motion.C_b_n(0.0))
        ends.append(integrate_arrays(values[:, :3], values[:, 3:], 1 / rate, start, position_fixed=True).C_b_n[-1])
    return rotvec_from_dcm(ends[0] @ ends[1].T)


def wobbling(
    order: int = 2,
    amplitude: float = WOBBLE,
    *,
    test: TurnTest | None = None,
    sense: int = 1,
    **changes,
) -> TurnMotion:
    """A test on a table without any error but a circular wobble, the same in every turn.

    Parameters
    ----------
    order : int, optional
        Periods in a turn.
    amplitude : float, optional
        Rad; the axis goes round in the sense of the turn.
    test : TurnTest, optional
        The paper's first one by default.
    sense : {1, -1}, optional
        Of the turn.
    **changes
        Arguments of `RoughTable`.
    """
    test = test or nine_tests()[0]
    wobble = Harmonic(order=order, amplitude=(amplitude, amplitude, 0.0), phase=(0.0, -np.pi / 2, 0.0))
    table = RoughTable(latitude=LATITUDE, **{"wobble": (wobble,)} | changes)
    return table.motions([reversed_test(test) if sense < 0 else test])[0]


def reversed_test(test: TurnTest) -> TurnTest:
    """The test from the same start with the turn the other way round."""
    return replace(test, label=f"{test.label} back", angle=-test.angle)
