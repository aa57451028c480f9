"""The paper's equations (3), (4), (8)-(19), (26) and (29)-(31), derived by symbols and set beside the print.

`equations` holds for each of them what follows, what the paper prints, and the correction of the ledger. The derivation
starts from two statements only: a computed attitude follows the gyros, and a computed force is the reading of the
accelerometers taken to the level by the computed attitude. To first order in the errors they give `attitude_error_rate`
and `slope_errors`; the rest is algebra with attitudes that are left general.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import TYPE_CHECKING

from fogkit.calibration.navigation_based import turn_model
from fogkit.claims import Proof

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol

_AXES = (0, 1, 2)


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

    return len(left) == len(right) and all(sp.cancel(sp.expand(a - b)) == 0 for a, b in zip(left, right, strict=True))


def proof(name: str) -> Proof:
    """The proof of the row whose id ends in `name`."""
    return equations()[name].proof


@cache
def equations() -> dict[str, Equation]:
    """Equations by the ending of their row in the ledger."""
    return _attitude_error() | _changes() | _matrix_rows() | _scale_factors() | _gyro_biases()


# Symbols


def gravity() -> Symbol:
    """g_0."""
    import sympy as sp

    return sp.Symbol("g_0", positive=True)


def general_attitude(name: str) -> Matrix:
    """Any rotation but half a turn, by Cayley's parameters: rational in three symbols, orthogonal identically."""
    import sympy as sp

    p = sp.Matrix(sp.symbols(f"{name}_1:4", real=True))
    S = _cross(p)
    return ((1 - p.dot(p)) * sp.eye(3) + 2 * p * p.T + 2 * S) / (1 + p.dot(p))


def errors() -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """m^a, m^g, b^a and b^g."""
    import sympy as sp

    m_a, m_g = (sp.Matrix(3, 3, sp.symbols(f"{name}_1:4(1:4)", real=True)) for name in ("m^a", "m^g"))
    b_a, b_g = (sp.Matrix(sp.symbols(f"{name}_1:4", real=True)) for name in ("b^a", "b^g"))
    return m_a, m_g, b_a, b_g


def _cross(v: Matrix) -> Matrix:
    """Matrix of the vector product with `v`."""
    import sympy as sp

    return sp.Matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


# The two statements


def attitude_error_rate() -> tuple[Matrix, Matrix]:
    """Rate of the attitude error: what the gyros' errors put into the computed attitude, and (10) under the integral.

    With ``(I + [theta x]) C`` for the computed attitude, ``C' = C [omega x]`` and the readings ``omega + m^g omega``,
    the terms of first order of ``d/dt (I + [theta x]) C = (I + [theta x]) C [(omega + m^g omega) x]`` leave
    ``[theta' x] = C [m^g omega x] C^T``.

    Returns
    -------
    tuple of sympy.Matrix
        That matrix, and ``[C m^g omega x]``; equal for every attitude.
    """
    import sympy as sp

    C = general_attitude("p")
    u = errors()[1] * sp.Matrix(sp.symbols("omega_1:4", real=True))
    return (C * _cross(u) * C.T).applyfunc(sp.cancel), _cross(C * u)


@cache
def slope_errors() -> Matrix:
    """Computed acceleration of a unit at rest, first order: what accelerometers and an attitude error theta make of it.

    The derivative by epsilon of ``(I + eps [theta x]) C ((I + eps m^a) A + eps b^a)`` with the true specific force
    ``A = C^T (0, 0, g_0)``, in a general attitude.
    """
    import sympy as sp

    eps = sp.Symbol("epsilon", real=True)
    C, (m_a, _, b_a, _) = general_attitude("p"), errors()
    A = C.T * sp.Matrix([0, 0, gravity()])
    computed = (sp.eye(3) + eps * _cross(theta())) * C * ((sp.eye(3) + eps * m_a) * A + eps * b_a)
    return computed.diff(eps).subs(eps, 0)


@cache
def _tilts() -> Matrix:
    """Derivatives of the computed acceleration by theta, which do not depend on the attitude."""
    import sympy as sp

    return slope_errors().jacobian(theta()).applyfunc(sp.cancel)


def theta() -> Matrix:
    """Attitude error of (10): the computed attitude is the true one turned by it."""
    import sympy as sp

    return sp.Matrix(sp.symbols("theta_1:4", real=True))


# The equations


def _attitude_error() -> dict[str, Equation]:
    import sympy as sp

    exact, printed = attitude_error_rate()
    C = [sp.Matrix(3, 3, sp.symbols(f"C{p}_1:4(1:4)", real=True)) for p in (1, 2)]  # at two steps
    turned = [sp.Matrix(sp.symbols(f"Phi{p}_1:4", real=True)) for p in (1, 2)]
    m_g = errors()[1]
    summed = C[0] * m_g * turned[0] + C[1] * m_g * turned[1]
    angles = {
        (i, k, j): sum(A[i, k] * phi[j] for A, phi in zip(C, turned, strict=True))
        for i, k, j in product(_AXES, repeat=3)
    }
    by_angles = [sum(angles[i, k, j] * m_g[k, j] for k, j in product(_AXES, repeat=2)) for i in (0, 1)]
    return {
        "eq10": Equation(tuple(exact), tuple(printed)),
        "eq11": Equation(tuple(summed[:2]), tuple(by_angles)),
    }


def _changes() -> dict[str, Equation]:
    import sympy as sp

    g, (m_a, _, b_a, _), t = gravity(), errors(), theta()
    C = general_attitude("p")
    A = C.T * sp.Matrix([0, 0, g])
    alpha = [sum(C[i, p] * (b_a[p] + sum(m_a[p, j] * A[j] for j in _AXES)) for p in _AXES) for i in (0, 1)]
    accelerometers = slope_errors().subs(dict.fromkeys(t, 0))
    gyros = _tilts() * t  # what theta adds after the turn
    return {
        "eq03": Equation((gyros[0],), (-g * t[1],), (g * t[1],)),
        "eq04": Equation((gyros[1],), (g * t[0],), (-g * t[0],)),
        "eq09": Equation(tuple(accelerometers[:2]), tuple(alpha)),
    }


def _matrix_rows() -> dict[str, Equation]:
    """(14)-(19): the derivatives of the change of slope, by the elements that (13) keeps, in its order."""
    import sympy as sp

    g, (m_a, m_g, b_a, _) = gravity(), errors()
    C = {n: sp.Matrix(3, 3, sp.symbols(f"C{n}_1:4(1:4)", real=True)) for n in (1, 2)}  # at t_1 and t_2
    A = {n: sp.Matrix(sp.symbols(f"A{n}_1:4", real=True)) for n in (1, 2)}
    Theta = {key: sp.Symbol("Theta_{}{}{}".format(*key), real=True) for key in product(_AXES, repeat=3)}
    turned = [sum(Theta[i, k, j] * m_g[k, j] for k, j in product(_AXES, repeat=2)) for i in (0, 1)]
    acc = C[2] * (m_a * A[2] + b_a) - C[1] * (m_a * A[1] + b_a)
    changes = acc[0] + g * turned[1], acc[1] - g * turned[0]
    state = {f"m_a_{i + 1}{j + 1}": m_a[i, j] for i, j in product(_AXES, repeat=2)}
    state |= {f"m_g_{i + 1}{j + 1}": m_g[i, j] for i, j in product(_AXES, repeat=2)}
    state |= {f"b_a_{i + 1}": b_a[i] for i in _AXES}
    q = (2, 0, 1)  # printed: q(1) = 3, q(2) = 1, q(3) = 2
    result = {}
    for row, numbers in enumerate(((14, 15, 16), (17, 18, 19))):
        derived = [changes[row].diff(state[name]) for name in turn_model.PARAMETERS]
        other, sign = 1 - row, 1 - 2 * row
        printed = (
            tuple(C[2][row, i] * A[2][q[i]] - C[1][row, i] * A[1][q[i]] for i in _AXES),
            tuple(sign * g * Theta[other, i, j] for i, j in product(_AXES, repeat=2)),
            tuple(C[2][row, i] - C[1][row, i] for i in _AXES),
        )
        parts = (derived[:3], derived[3:12], derived[12:])
        for number, part, print_ in zip(numbers, parts, printed, strict=True):
            result[f"eq{number}"] = Equation(tuple(part), print_)
    return result


def vertical_accelerations(C_1: Matrix, C_2: Matrix) -> tuple[Expr, Expr]:
    """Computed vertical accelerations of the two dwells, gravity taken off, with accelerometer errors alone."""
    import sympy as sp

    g, (m_a, _, b_a, _) = gravity(), errors()
    up = sp.Matrix([0, 0, g])
    return tuple((C * ((sp.eye(3) + m_a) * C.T * up + b_a) - up)[2] for C in (C_1, C_2))


def _upended(axis: int) -> tuple[Matrix, Matrix]:
    """Attitudes in the two dwells of the test that turns an axis, 1 to 3, upside down in the recovered plan."""
    import numpy as np
    import sympy as sp

    from fogkit.reproduction.klimkovich.plan_search import attitude, recovered_plan, upended_axes

    turn = recovered_plan()[upended_axes(recovered_plan())[axis] - 1]
    return tuple(sp.Matrix(np.round(attitude(letters)).astype(int)) for letters in (turn.start, turn.end))


def _scale_factors() -> dict[str, Equation]:
    g, (m_a, _, _, _) = gravity(), errors()
    sums = []
    for axis in (1, 2, 3):
        before, after = vertical_accelerations(*_upended(axis))
        sums.append((after + before) / (2 * g))
    return {"eq26": Equation(tuple(sums), tuple(m_a[i, i] for i in _AXES))}


def half_difference(axis: int) -> Expr:
    """What the footnote of table 1 prints for accelerometer `axis`, 1 to 3: half the difference over gravity."""
    before, after = vertical_accelerations(*_upended(axis))
    return ((after - before) / (2 * gravity())).expand()


def scale_factor_of_a_tilted_axis() -> Expr:
    """(26) with perfect accelerometers whose axis x is upright but for a tilt, in both dwells, second order in it.

    The navigation takes the axis to be upright, as the plan has it.
    """
    import sympy as sp

    gamma = sp.Symbol("gamma", real=True)
    reading = sp.cos(gamma)  # along the axis, up then down, in units of gravity
    half_sum = ((reading - 1) + (reading - 1)) / 2
    return sp.series(half_sum, gamma, 0, 4).removeO()


def _gyro_biases() -> dict[str, Equation]:
    """Position 1 and, half a turn about the vertical from it, position 2; theta grows by C b^g in either dwell."""
    import sympy as sp

    g, b_g = gravity(), errors()[3]
    curvature, yaw = [], []
    for C in (sp.eye(3), sp.diag(-1, -1, 1)):
        growth = C * b_g
        curvature.append(_tilts() * growth)  # second derivatives of the velocity
        yaw.append(-growth[2])  # clockwise from north
    estimates = (
        (curvature[1][1] - curvature[0][1]) / (2 * g),
        -(curvature[1][0] - curvature[0][0]) / (2 * g),
        -(yaw[1] + yaw[0]) / 2,
    )
    return {f"eq{29 + i}": Equation((b_g[i],), (estimates[i],)) for i in _AXES}
