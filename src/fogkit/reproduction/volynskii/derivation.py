"""The paper's equations (2) to (23), derived by symbols and set beside the print.

`equations` holds for each of them what follows, what the paper prints, and the correction of the ledger. Signs and
indices come from attitudes: the unit is turned by rotation matrices and the Earth rate is taken to the gyro's axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from fogkit.claims import Proof

if TYPE_CHECKING:
    from sympy import Expr, Matrix


@dataclass(frozen=True)
class Equation:
    """One equation of the paper, component by component.

    Attributes
    ----------
    derived, printed : tuple of sympy.Expr
        Right-hand sides.
    corrected : tuple of sympy.Expr, optional
        Right-hand sides as the ledger corrects them.
    """

    derived: tuple[Expr, ...]
    printed: tuple[Expr, ...]
    corrected: tuple[Expr, ...] | None = None

    @property
    def proof(self) -> Proof:
        """Whether the print, and the correction, are what follows."""
        corrected = None if self.corrected is None else _same(self.derived, self.corrected)
        return Proof(printed=_same(self.derived, self.printed), corrected=corrected)


def _same(left: tuple[Expr, ...], right: tuple[Expr, ...]) -> bool:
    import sympy as sp

    return len(left) == len(right) and all(
        sp.simplify(sp.expand(sp.expand_trig(a - b))) == 0 for a, b in zip(left, right, strict=True)
    )


def proof(name: str) -> Proof:
    """The proof of the row whose id ends in `name`."""
    return equations()[name].proof


@cache
def equations() -> dict[str, Equation]:
    """Equations by the ending of their row in the ledger."""
    return _rocking() | _frames() | _biases() | _averages() | _scale_factors() | _small_angles() | _accuracy()


def turn(axis: str, angle: Expr) -> Matrix:
    """Active right-handed rotation about a coordinate axis."""
    import sympy as sp

    s, c = sp.sin(angle), sp.cos(angle)
    return sp.Matrix(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


def _rocking() -> dict[str, Equation]:
    """Mean over a period of harmonic rocking, scale factors half the asymmetry to either side of their mean."""
    import sympy as sp

    asymmetry, amplitude, phase = sp.symbols("Delta A phi", positive=True)
    rate = amplitude * sp.sin(phase)
    halves = sp.integrate(asymmetry / 2 * rate, (phase, 0, sp.pi)) - sp.integrate(
        asymmetry / 2 * rate, (phase, sp.pi, 2 * sp.pi)
    )
    product = asymmetry * amplitude
    return {"eq02": Equation((halves / (2 * sp.pi),), (product * 2 / sp.pi,), (product / sp.pi,))}


def pyramid(alpha: Expr, beta: Expr) -> Matrix:
    """B of (3), as printed."""
    import sympy as sp

    sa, ca, sb, cb = sp.sin(alpha), sp.cos(alpha), sp.sin(beta), sp.cos(beta)
    return sp.Matrix([[cb, -sb * sa, sb * ca], [0, ca, sa], [-sb, -cb * sa, cb * ca]])


def input_axes(angles: tuple[Expr, ...]) -> Matrix:
    """A_g of (6), as printed, of the angles alpha_yx, alpha_zx, beta_xy, beta_zy, gamma_xz, gamma_yz."""
    import sympy as sp

    s, c = [sp.sin(angle) for angle in angles], [sp.cos(angle) for angle in angles]
    return sp.Matrix(
        [
            [c[2] * c[4], s[4] * c[2], -s[2] * c[4]],
            [-s[5] * c[0], c[0] * c[5], s[0] * c[5]],
            [s[3] * c[1], -s[1] * c[3], c[1] * c[3]],
        ]
    )


def _frames() -> dict[str, Equation]:
    import sympy as sp

    alpha, beta, gamma = sp.symbols("alpha_0 beta_0 gamma", real=True)
    B = pyramid(alpha, beta)
    C = sp.Matrix([[sp.cos(gamma), sp.sin(gamma), 0], [-sp.sin(gamma), sp.cos(gamma), 0], [0, 0, 1]])
    turned = turn("z", gamma)  # its columns are the block's axes in the case
    axes = turned * B.T  # columns: nominal gyro axes in the case
    angles = sp.symbols("alpha_yx alpha_zx beta_xy beta_zy gamma_xz gamma_yz", real=True)
    A_g = input_axes(angles)
    one_by_one, as_printed = [], []
    for i, (gyro, axis) in enumerate(("yx", "zx", "xy", "zy", "xz", "yz")):
        row = "xyz".index(gyro)
        alone = A_g.subs({angle: 0 for k, angle in enumerate(angles) if k != i})
        one_by_one += list(turn(axis, angles[i])[:, row])
        as_printed += list(alone[row, :])
    rows = [A_g[i, :] for i in range(3)]
    unit_rows = [row / sp.sqrt(1 - (row[j] * row[k] / row[i]) ** 2) for i, j, k, row in _with_indices(rows)]
    ones = (sp.Integer(1),) * 3
    return {
        # a rotation about X_B by alpha_0, then about Y by -beta_0, in components
        "eq03": Equation(tuple(turn("y", beta) * turn("x", -alpha)), tuple(B)),
        "eq04": Equation(tuple(turned.T), tuple(C)),
        "eq05": Equation(tuple(axes.T), tuple(B * C)),
        "eq06": Equation(tuple(one_by_one), tuple(as_printed)),
        "eq06-unit": Equation(ones, tuple(row.dot(row) for row in rows), tuple(row.dot(row) for row in unit_rows)),
    }


def _with_indices(rows: list[Matrix]) -> list[tuple]:
    """Each row of A_g behind its diagonal index and the two others; product of the others over the diagonal entry is
    the product of the sines of the row's two angles."""
    return [(i, (i + 1) % 3, (i + 2) % 3, row) for i, row in enumerate(rows)]


def _biases() -> dict[str, Equation]:
    """Readings at rest: ``g + (row . Earth rate) / M`` by (11), in the positions of (7) and (9)."""
    import sympy as sp

    K, lat, w, g, M, theta = sp.symbols("K varphi Omega g_0x M theta", positive=True)
    Cxx, Cxy, Cxz, g_y = sp.symbols("C_xx C_xy C_xz g_0y", real=True)
    row, wc, ws = sp.Matrix([[Cxx, Cxy, Cxz]]), w * sp.cos(lat), w * sp.sin(lat)
    earth = sp.Matrix([0, wc, ws])  # east, north, up

    def reading(axes, scale):
        """Reading of a gyro in a unit whose axes, in columns, are given in east, north, up."""
        return g + (row * axes.T * earth)[0] / scale

    start = turn("z", -K)  # course clockwise; at K = 0 the axes X_0, Y_0, Z_0 are east, north, up
    about_up = turn("z", sp.pi)

    def positions(about_horizontal):
        second = about_up * start
        third = about_horizontal * second
        return start, second, third, about_up * third

    # the horizontal axis of (7) is X_0 as it lies after the first turn
    along_x = about_up * start * turn("x", sp.pi) * (about_up * start).T
    any_axis = turn("z", theta) * turn("x", sp.pi) * turn("z", -theta)
    ones = tuple(reading(axes, 1) for axes in positions(along_x))
    a, b, c = Cxx * wc * sp.sin(K), Cxy * wc * sp.cos(K), Cxz * ws
    printed = (g - a + b + c, g + a - b + c, g + a + b - c, g - a - b - c)
    scaled = tuple(reading(axes, M) for axes in positions(along_x))
    # the same sum for a unit in any attitude (three angles), turned about any horizontal axis
    e1, e2, e3 = sp.symbols("e_1 e_2 e_3", real=True)
    attitude = turn("z", e1) * turn("x", e2) * turn("z", e3)
    fours = (attitude, about_up * attitude, any_axis * about_up * attitude)
    fours = (*fours, about_up * fours[-1])

    north = turn("z", sp.pi / 2)  # X_0 to the north, Y_0 to the west
    south = turn("x", sp.pi) * north  # after half a turn about the east-west axis
    pair = (reading(north, 1), reading(south, 1))
    pair_any = (reading(attitude, M), reading(turn("x", sp.pi) * attitude, M))
    q1, q2 = g + Cxx * wc + Cxz * ws, g - Cxx * wc - Cxz * ws
    return {
        "eq07": Equation(ones, printed),
        "eq07-scale": Equation(scaled, printed, tuple(g + (p - g) / M for p in printed)),
        "eq08": Equation((sum(scaled) / 4,), (g,)),
        "four-arbitrary": Equation((sum(reading(axes, M) for axes in fours) / 4,), (g,)),
        "eq09": Equation(pair, (q1, q2)),
        "eq10": Equation((sum(pair) / 2,), (g_y,), (g,)),
        "two-one-turn": Equation((sum(pair_any) / 2,), (g,)),
    }


def _averages() -> dict[str, Equation]:
    """Mean input of a gyro over whole turns of the table, for each of the three axes of rotation."""
    import sympy as sp

    a, lat, w, rate, outer = sp.symbols("a varphi Omega alpha_dot gamma_dot", positive=True)
    row = sp.Matrix([sp.symbols("C_jx C_jy C_jz", real=True)])
    earth = sp.Matrix([0, w * sp.cos(lat), w * sp.sin(lat)])

    def mean(start, axis, spin):
        axes = turn(axis, a) * start
        along = {"x": sp.Matrix([1, 0, 0]), "z": sp.Matrix([0, 0, 1])}[axis] * spin
        inputs = (row * axes.T * (earth + along))[0]
        return sp.integrate(sp.expand(inputs), (a, 0, 2 * sp.pi)) / (2 * sp.pi)

    x_east, y_east = turn("z", 0), turn("z", -sp.pi / 2)
    derived = (mean(x_east, "x", rate), mean(y_east, "x", rate), mean(x_east, "z", outer))
    printed = (row[0] * rate, row[1] * rate, row[2] * (outer + w * sp.sin(lat)))
    return {"eq11": Equation(derived, printed)}


def _scale_factors() -> dict[str, Equation]:
    """(13), (14), (16), (17) from (11) times T; I is the integral of the reading less the bias."""
    import sympy as sp

    angle, outer, T, w, lat, U, integral = sp.symbols("alpha gamma T Omega varphi U I", positive=True)
    M, C, first, c2, c3 = sp.symbols("M C M_1 c_2 c_3", positive=True)
    turned = outer + w * sp.sin(lat) * T
    turned_u = outer + U * sp.sin(lat) * T

    def scale(cosine, path):
        """M from (11) integrated over T: M I = cosine * path."""
        return sp.solve(sp.Eq(M * integral, cosine * path), M)[0]

    def cosine(scale_factor, path):
        return sp.solve(sp.Eq(scale_factor * integral, C * path), C)[0]

    second = 1 - c2**2 / 2 - c3**2 / 2
    paths = (angle, angle, turned)
    first_true = tuple(scale(1, path) for path in paths)
    second_true = tuple(scale(second, path) for path in paths)
    return {
        "eq13": Equation(first_true, tuple(p / (T * integral) for p in paths), tuple(p / integral for p in paths)),
        "eq13-u": Equation((scale(1, turned),), (turned_u / integral,), (turned / integral,)),
        "eq14": Equation(tuple(cosine(first, p) for p in paths), tuple(first * integral / p for p in paths)),
        "eq16": Equation(
            second_true, tuple(p * second / (T * integral) for p in paths), tuple(p * second / integral for p in paths)
        ),
        "eq17": Equation(tuple(cosine(M, p) for p in paths), tuple(M * integral / p for p in paths)),
    }


def _small_angles() -> dict[str, Equation]:
    """The expansions of (15), by total degree in the two angles."""
    import sympy as sp

    a, b = sp.symbols("alpha beta", positive=True)
    cosines, sine = expansion("cos", 3), expansion("sin", 4)
    return {
        "eq15-cos": Equation((cosines,), (1 - a**2 / 2 - b**2 / 2,)),
        "eq15-sin": Equation((sine,), (1 - a**3 / 2 - a * b**2 / 2,), (a - a**3 / 6 - a * b**2 / 2,)),
    }


def expansion(first: str, below: int, start: int = 0) -> Expr:
    """Terms of ``cos(alpha) cos(beta)`` or ``sin(alpha) cos(beta)`` with total degree from `start` to below `below`.

    Parameters
    ----------
    first : {"cos", "sin"}
        The function of alpha.
    below, start : int
        Degrees.
    """
    import sympy as sp

    a, b, x = sp.symbols("alpha beta x", positive=True)
    product = (sp.cos if first == "cos" else sp.sin)(x * a) * sp.cos(x * b)
    series = sp.expand(sp.series(product, x, 0, below).removeO())
    return sum(series.coeff(x, degree) for degree in range(start, below))


def terms_at(first: str, degree: int, angle: float) -> float:
    """Size of the terms of one total degree of `expansion`, both angles being `angle`, rad."""
    import sympy as sp

    a, b = sp.symbols("alpha beta", positive=True)
    return abs(float(expansion(first, degree + 1, degree).subs({a: angle, b: angle})))


def _accuracy() -> dict[str, Equation]:
    """(18) to (23): first variations, and standard deviations of independent parts."""
    import sympy as sp

    M, integral, path, C = sp.symbols("M I alpha C", positive=True)
    dM, dI, da_0, da_T, x = sp.symbols("dM dI da_0 da_T x", real=True)

    def variation(expression, changes):
        moved = expression.subs({symbol: symbol + x * change for symbol, change in changes.items()}, simultaneous=True)
        return sp.diff(moved, x).subs(x, 0)

    start, end = sp.symbols("alpha_0 alpha_T", positive=True)
    left = variation(M * integral, {M: dM, integral: dI})
    right = variation(end - start, {end: da_T, start: da_0})
    # M I = path; the reading's error counts against the scale factor found
    relative = sp.solve(sp.Eq(left, right), dM)[0] / M
    denominator = M * integral
    printed_20 = (da_T + da_0 + dI) / integral
    corrected_20 = (da_T - da_0 - M * dI) / denominator

    # standard deviations: readout a, integral of the drift s; n turns
    a, s, n, T, g, c = sp.symbols("sigma_a sigma_I n T sigma_g C_n", positive=True)
    turned = 2 * sp.pi * n

    def deviation(expression, sigmas):
        return sp.sqrt(sum(sp.diff(expression, symbol) ** 2 * sigma**2 for symbol, sigma in sigmas.items()))

    at_turns = relative.subs(integral, turned / M)
    total = sp.simplify(deviation(at_turns, {da_T: a, da_0: a, dI: s}))
    drift = sp.sqrt((g * T) ** 2 + c**2 * 2 * sp.pi * T)
    printed_21, corrected_21 = (a * sp.sqrt(2) + s) / turned, sp.sqrt(2 * a**2 + M**2 * s**2) / turned
    printed_22 = (a + g * T + c * sp.sqrt(2 * sp.pi * T)) / turned
    corrected_22 = sp.sqrt(2 * a**2 + M**2 * ((g * T) ** 2 + 2 * sp.pi * T * c**2)) / turned

    da = sp.Symbol("da", real=True)
    cosine = variation(M * integral / path, {M: dM, integral: dI, path: da}).subs(integral, C * path / M)
    printed_23 = dM / M + C * da / path + M * dI / path
    corrected_23 = C * dM / M - C * da / path + M * dI / path
    return {
        "eq18": Equation((left, right), (dM * integral + M * dI, da_T + da_0), (dM * integral + M * dI, da_T - da_0)),
        "eq19": Equation((sp.solve(sp.Eq(M, path / integral), path)[0],), (M * integral,)),
        "eq20": Equation((relative,), (printed_20,), (corrected_20,)),
        "eq21": Equation((total,), (printed_21,), (corrected_21,)),
        "eq22": Equation((total.subs(s, drift),), (printed_22,), (corrected_22,)),
        "eq23": Equation((cosine,), (printed_23,), (corrected_23,)),
    }
