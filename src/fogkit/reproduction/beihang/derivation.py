"""The 24 points and the turns, by symbols: what is found, and how levelling, azimuth and the cube disturb it.

A cube with the unit lies on a plate; p is the frame of the plate, nominally east, north, up, u its normal. All proofs
carry gravity and Earth rate as vectors of p with arbitrary components, so they hold for any azimuth and any tilt of the
plate; the tilt comes in at the end, by the components along u. Readings of a gyro are in units of its equivalent.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from fogkit.reproduction.beihang.points import attitude, positions, vertical_axis

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol


def mean_input(labels: tuple[str, ...], v: Matrix, errors: tuple[Expr, ...] = (0, 0, 0, 0)) -> Matrix:
    """Mean over the points of a position of a constant vector `v` of the plate, in body axes.

    `errors` are errors of the four angles about the normal of the plate, rad, clockwise from above.
    """
    import sympy as sp

    def turned(angle):
        c, s = sp.cos(angle), sp.sin(angle)
        return sp.Matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]])

    total = sp.zeros(3, 1)
    for label, error in zip(labels, errors, strict=True):
        total += (turned(error) * attitude(label)).T * v
    return (total / len(labels)).applyfunc(sp.expand)


def plate_vector(name: str) -> Matrix:
    """Vector with arbitrary components ``<name>_e, <name>_n, <name>_u`` in the plate."""
    import sympy as sp

    return sp.Matrix(sp.symbols(f"{name}_e {name}_n {name}_u", real=True))


@cache
def horizontal_cancels() -> bool:
    """Whether in all six positions only the component along the normal of the plate is left, on the vertical axis."""
    v = plate_vector("v")
    return all(mean_input(labels, v) == v[2] * vertical_axis(name) for name, labels in positions().items())


def horizontal_left_by_angle_errors() -> dict[str, Expr]:
    """Horizontal component left by errors of the quarter turns, of first order, in units of the horizontal vector.

    "one": of one point by 1 rad; "proportional": of every quarter turn by 1 rad, errors 0, 1, 2, 3.
    """
    import sympy as sp

    error = sp.Symbol("epsilon", real=True)
    v = sp.Matrix([1, 0, 0])
    result = {}
    for name, errors in {"one": (0, error, 0, 0), "proportional": (0, error, 2 * error, 3 * error)}.items():
        left = mean_input(positions()["1"], v, errors).diff(error).subs(error, 0)
        result[name] = sp.sqrt(left.dot(left))
    return result


# The components along the normal of a plate that is tilted by delta towards the azimuth psi.


def along_normal() -> dict[str, Expr]:
    """Specific force and Earth rate along the normal of a tilted plate."""
    import sympy as sp

    g, w, lat, tilt, azimuth = tilt_symbols()
    normal = sp.Matrix([sp.sin(tilt) * sp.sin(azimuth), sp.sin(tilt) * sp.cos(azimuth), sp.cos(tilt)])
    force, rate = sp.Matrix([0, 0, g]), sp.Matrix([0, w * sp.cos(lat), w * sp.sin(lat)])
    return {"force": force.dot(normal), "rate": sp.expand(rate.dot(normal))}


def tilt_symbols() -> tuple[Symbol, ...]:
    """Gravity, Earth rate, latitude, tilt of the plate and azimuth of the tilt."""
    import sympy as sp

    return sp.symbols("g Omega varphi delta psi", positive=True)


# Estimates from the means of the six positions


def design() -> Matrix:
    """Rows 1, a_x, a_y, a_z of the six equations of one sensor, with gravity as it is on a level plate."""
    import sympy as sp

    g = tilt_symbols()[0]
    return sp.Matrix([[1, *(g * vertical_axis(name))] for name in positions()])


def regression(readings: Matrix) -> Matrix:
    """Multiple regression of six readings: zero term, then the components along x, y, z."""
    import sympy as sp

    X = design()
    return ((X.T * X).inv() * X.T * readings).applyfunc(sp.expand)


def closed_forms(readings: Matrix) -> Matrix:
    """Mean of the six, then half differences of up and down over gravity."""
    import sympy as sp

    g = tilt_symbols()[0]
    halves = [(readings[2 * i] - readings[2 * i + 1]) / (2 * g) for i in range(3)]
    return sp.Matrix([sum(readings) / 6, *halves]).applyfunc(sp.expand)


@cache
def regression_is_closed_forms() -> bool:
    """Whether regression and closed forms are the same, for any six readings."""
    import sympy as sp

    readings = sp.Matrix(sp.symbols("F_1:7", real=True))
    return regression(readings) == closed_forms(readings)


def zero_term_variances() -> tuple[Expr, Expr]:
    """Variance of the mean of six, and of the mean of the one pair in which an axis is up and down, of one reading."""
    import sympy as sp

    readings = sp.Matrix(sp.symbols("F_1:7", real=True))
    six, pair = regression(readings)[0], (readings[0] + readings[1]) / 2
    return tuple(sum(sp.diff(one, reading) ** 2 for reading in readings) for one in (six, pair))


@cache
def estimates(tilted: bool = True) -> dict[str, tuple[Matrix, Matrix]]:
    """What the 24 points and the turns give, and what they should: (found, true) of each kind of coefficient.

    "accelerometer": zero term and three components. "gyro": zero term and three g-dependent terms, the cosines known.
    "turns": the three components from turns of equal duration. On a plate with any tilt, or a level one.
    """
    import sympy as sp

    g, w, lat, *_ = tilt_symbols()
    level = {"force": g, "rate": w * sp.sin(lat)}
    u = along_normal() if tilted else level
    k0, d0 = sp.symbols("K_0 D_0", real=True)
    K, c, D = (sp.Matrix(sp.symbols(f"{name}_x {name}_y {name}_z", real=True)) for name in "KcD")
    names = list(positions())
    accelerometer = sp.Matrix([k0 + u["force"] * K.dot(vertical_axis(name)) for name in names])
    gyro = sp.Matrix([d0 + (u["rate"] * c + u["force"] * D).dot(vertical_axis(name)) for name in names])
    known = sp.Matrix([level["rate"] * c.dot(vertical_axis(name)) for name in names])
    equal = sp.Symbol("t", positive=True)
    return {
        "accelerometer": (regression(accelerometer), sp.Matrix([k0, *K])),
        "gyro": (regression(gyro - known), sp.Matrix([d0, *D])),
        "turns": (sp.Matrix([from_turns(axis, equal, equal) for axis in range(3)]), c),
    }


def from_turns(axis: int, forward: Expr, back: Expr) -> Expr:
    """Component of a gyro along a body axis, from one turn each way with that axis up; durations of the two, s.

    Readings less those at rest are not used: what the zero term, the Earth rate and gravity add is what unequal
    durations leave. Earth rate and gravity along the plate turn with it, and their integrals are carried out.
    """
    import sympy as sp

    d0, t = sp.Symbol("D_0", real=True), sp.Symbol("tau", real=True)
    c, D = (sp.Matrix(sp.symbols(f"{name}_x {name}_y {name}_z", real=True)) for name in "cD")
    omega, force = plate_vector("omega"), plate_vector("f")
    start = attitude(positions()[str(2 * axis + 1)][0])

    def turned(sign, duration):
        """Reading over a whole turn, counter-clockwise for a positive sign."""
        angle = sign * 2 * sp.pi * t / duration
        cos, sin = sp.cos(angle), sp.sin(angle)
        into_body = (sp.Matrix([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) * start).T
        spin = sp.Matrix([0, 0, sign * 2 * sp.pi / duration])
        rate = d0 + c.dot(into_body * (omega + spin)) + D.dot(into_body * force)
        return sp.integrate(sp.expand(rate), (t, 0, duration))

    return sp.expand(sp.simplify((turned(1, forward) - turned(-1, back)) / (4 * sp.pi)))


def turns_error() -> Expr:
    """Error of the component along the vertical axis, x, that unequal durations leave."""
    import sympy as sp

    forward, back = sp.symbols("t_+ t_-", positive=True)
    return sp.factor(from_turns(0, forward, back) - sp.Symbol("c_x", real=True))


def expected_turns_error() -> Expr:
    """What `turns_error` should be: all that does not turn, times the difference of durations, over two turns."""
    import sympy as sp

    forward, back = sp.symbols("t_+ t_-", positive=True)
    d0, c, D, omega, force = sp.symbols("D_0 c_x D_x omega_u f_u", real=True)
    return (d0 + c * omega + D * force) * (forward - back) / (4 * sp.pi)


@cache
def level_estimates_are_exact() -> bool:
    """Whether on a level plate all coefficients come out exactly, whichever way north is."""
    import sympy as sp

    return all((found - true).applyfunc(sp.simplify).is_zero_matrix for found, true in estimates(False).values())


def equivalent_and_cosines(components: Matrix) -> tuple[Expr, Matrix]:
    """Equivalent (length) and direction cosines of three components."""
    import sympy as sp

    length = sp.sqrt(components.dot(components))
    return length, components / length


@cache
def mislevelling_order() -> dict[str, int | None]:
    """Lowest order of the tilt in the error of each coefficient; None where the coefficient is exact."""
    (accelerometer, K), (gyro, D), (turned, c) = estimates().values()
    length, true_length = equivalent_and_cosines(accelerometer[1:, :])[0], equivalent_and_cosines(K[1:, :])[0]
    cosines = equivalent_and_cosines(accelerometer[1:, :])[1] - equivalent_and_cosines(K[1:, :])[1]
    return {
        "accelerometer zero term": _order(accelerometer[0] - K[0]),
        "accelerometer equivalent": _order(length - true_length),
        "accelerometer cosines": _lowest(cosines),
        "gyro zero term": _order(gyro[0] - D[0]),
        "gyro g-dependent terms": _lowest(gyro[1:, :] - D[1:, :]),
        "gyro equivalent": _order(equivalent_and_cosines(turned)[0] - equivalent_and_cosines(c)[0]),
        "gyro cosines": _lowest(turned - c),
    }


def gyro_g_term_error() -> Expr:
    """Error of a g-dependent term by a tilt of the plate, to first order."""
    tilt = tilt_symbols()[3]
    found, true = estimates()["gyro"]
    return (found[1] - true[1]).diff(tilt).subs(tilt, 0) * tilt


def _order(error: Expr, limit: int = 3) -> int | None:
    """Lowest order of the tilt in an error, up to `limit`."""
    import sympy as sp

    tilt = tilt_symbols()[3]
    if sp.simplify(error) == 0:
        return None
    return next(n for n in range(limit + 1) if sp.simplify(sp.diff(error, tilt, n).subs(tilt, 0)) != 0)


def _lowest(errors: Matrix) -> int | None:
    return min((order for order in map(_order, errors) if order is not None), default=None)


# What static readings cannot tell apart, and what they can


def static_rank(with_g_terms: bool) -> int:
    """Rank of the six static equations of a gyro: zero term, equivalents and, if asked, g-dependent terms."""
    import sympy as sp

    g, w, lat, *_ = tilt_symbols()
    rows = [
        [1, *(w * sp.sin(lat) * vertical_axis(name)), *(g * vertical_axis(name) if with_g_terms else ())]
        for name in positions()
    ]
    return sp.Matrix(rows).rank()


def rank_of(labels: tuple[str, ...]) -> int:
    """Rank of the equations of one accelerometer, zero term and three components, from some attitudes."""
    import sympy as sp

    return sp.Matrix([[1, *attitude(label).T[:, 2]] for label in labels]).rank()


def rank_of_rates(axes: tuple[int, ...]) -> int:
    """Rank of the equations for three components of a gyro from rates about some of the body axes."""
    import sympy as sp

    return sp.Matrix([[int(i == axis) for i in range(3)] for axis in axes]).rank()
