"""Equations (6), (8), (13), (14) and (17) of the thesis, derived by symbols and set beside the print as restored.

The scan garbles them. A printed term is restored where its letters, or its place in a pattern that is legible
elsewhere, leave one reading; whether the reading is right is then seen from the derivation, which starts from turns by
heading, trim and roll, the mount, and the pyramid. Signs that the scan does not show are in `UNREADABLE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr

POINTS = 4
"""Random points at which two sides are compared, to 30 digits: sides that differ do so at each of them."""

UNREADABLE = {
    "eq06-heading": "the minus sign before the fraction",
    "eq08-velocity-east": "the minus sign of the first term",
    "eq08-gyro-x": "the indices of the pyramid's matrix",
    "eq08-gyro-y": "the indices of the pyramid's matrix: the third seems to be 1 where 3 is right",
    "eq17-gyro-x": "nearly all",
    "eq17-gyro-z": "the sign of the term with cos(trim)",
    "eq17-trim": "all but the last term",
}
"""What the scan does not show, by equation; it is restored from the pattern of the others."""


@dataclass(frozen=True)
class Equation:
    """One coefficient or equation of the thesis.

    Attributes
    ----------
    derived, printed : sympy.Expr
        What follows, and what is printed as restored.
    """

    derived: Expr
    printed: Expr

    @property
    def difference(self) -> float:
        """Largest difference at random points, over the derived value there."""
        import sympy

        symbols = sorted(self.derived.free_symbols | self.printed.free_symbols, key=str)
        largest = 0.0
        for point in range(POINTS):
            # irrational angles between 0.3 and 1.3, the same at every call
            at = {s: sympy.Rational(3, 10) + sympy.sqrt(2 + 7 * point + k) % 1 for k, s in enumerate(symbols)}
            derived, printed = (side.evalf(30, subs=at) for side in (self.derived, self.printed))
            largest = max(largest, abs(float((derived - printed) / derived)))
        return largest

    @property
    def holds(self) -> bool:
        """Whether both sides are the same function."""
        return self.difference < 1e-20


@cache
def _symbols() -> dict[str, Expr]:
    import sympy as sp

    names = "K theta gamma beta phi U R V_N V_E w_x w_y w_z w_xb w_yb w_zb beta_rate"
    return dict(zip(names.split(), sp.symbols(names, real=True), strict=True))


def _turns(K, theta, gamma):
    """Matrices A_K, A_theta, A_gamma that take components into the axes after each turn."""
    import sympy as sp

    s, c = sp.sin, sp.cos
    A_K = sp.Matrix([[c(K), 0, s(K)], [0, 1, 0], [-s(K), 0, c(K)]])
    A_theta = sp.Matrix([[c(theta), s(theta), 0], [-s(theta), c(theta), 0], [0, 0, 1]])
    A_gamma = sp.Matrix([[1, 0, 0], [0, c(gamma), s(gamma)], [0, -s(gamma), c(gamma)]])
    return A_K, A_theta, A_gamma


def _about_up(angle):
    """Matrix into axes turned about the second axis, counter-clockwise seen from its end."""
    import sympy as sp

    s, c = sp.sin(angle), sp.cos(angle)
    return sp.Matrix([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def _pyramid():
    """Matrix A_e from the mount to the gyros, exact: half a turn, atan(sqrt 2), an eighth of a turn."""
    import sympy as sp

    sine, cosine = sp.sqrt(2) / sp.sqrt(3), 1 / sp.sqrt(3)
    tilt = sp.Matrix([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    return _about_up(sp.pi / 4) * tilt * _about_up(sp.pi)


def _geographic(y):
    """Rates of north-up-east, (5)."""
    import sympy as sp

    north, east = y["V_N"] / y["R"], y["V_E"] / y["R"]
    return sp.Matrix([y["U"] * sp.cos(y["phi"]) + east, y["U"] * sp.sin(y["phi"]) + east * sp.tan(y["phi"]), -north])


def _angle_rates(y, hull):
    """Rates of heading, trim, roll, solved from the rate of the hull that they make: no formula of the print in it."""
    import sympy as sp

    A_K, A_theta, A_gamma = _turns(y["K"], y["theta"], y["gamma"])
    rates = sp.symbols("K_rate theta_rate gamma_rate")
    made = A_gamma * (A_theta * sp.Matrix([0, -rates[0], 0]) + sp.Matrix([0, 0, rates[1]]))
    made += sp.Matrix([rates[2], 0, 0])
    relative = hull - A_gamma * A_theta * A_K * _geographic(y)
    solution = sp.solve(list(made - relative), rates, dict=True)[0]
    return [solution[rate] for rate in rates]


@cache
def equations() -> dict[str, Equation]:
    """Equations and coefficients, by name.

    Returns
    -------
    dict of Equation
        ``eq06-...`` the three rates of angles, ``eq08-...`` the coefficients of the heading error's rate, ``eq13``,
        ``eq14-...`` coefficients of (14), ``eq17-...`` coefficients of (17).
    """
    return {**_kinematics(), **_heading_error(), **_gyro_y(), **_mount_off()}


def _kinematics() -> dict[str, Equation]:
    import sympy as sp

    y = _symbols()
    s, c, t = sp.sin, sp.cos, sp.tan(y["theta"])
    g, still = y["gamma"], {y["U"]: 0, y["V_N"]: 0, y["V_E"]: 0}
    hull = sp.Matrix([y["w_x"], y["w_y"], y["w_z"]])
    heading, trim, roll = (rate.subs(still) for rate in _angle_rates(y, hull))
    level = y["w_y"] * c(g) - y["w_z"] * s(g)
    return {
        "eq06-heading": Equation(heading, -level / c(y["theta"])),
        "eq06-trim": Equation(trim, y["w_y"] * s(g) + y["w_z"] * c(g)),
        "eq06-roll": Equation(roll, y["w_x"] - t * level),
    }


def _heading_error() -> dict[str, Equation]:
    import sympy as sp

    y = _symbols()
    K, th, g, b, phi, U, R, VN, VE = (y[n] for n in "K theta gamma beta phi U R V_N V_E".split())
    s, c, t = sp.sin, sp.cos, sp.tan
    hull = sp.Matrix([y["w_x"], y["w_y"], y["w_z"]])
    rate = _angle_rates(y, hull)[0]
    oN, _, oE = _geographic(y)
    A_e, gyros = _pyramid(), sp.Matrix([y["w_xb"], y["w_yb"], y["w_zb"]])
    from_gyros = _about_up(b).T * (A_e.T * gyros - sp.Matrix([0, y["beta_rate"], 0]))
    by_gyro = rate.subs(dict(zip(hull, from_gyros, strict=True)), simultaneous=True)
    printed = {
        "heading": oN * t(th) * s(K) - oE * t(th) * c(K),
        "trim": (y["w_z"] * s(g) - y["w_y"] * c(g)) * s(th) / c(th) ** 2 - (oN * c(K) + oE * s(K)) / c(th) ** 2,
        "roll": (y["w_y"] * s(g) + y["w_z"] * c(g)) / c(th),
        "velocity-north": t(th) * s(K) / R,
        "velocity-east": (-t(th) * c(K) + t(phi)) / R,
        "lat": t(th) * c(K) * U * s(phi) + U * c(phi) + VE / (R * c(phi) ** 2),
        "alt": t(th) * c(K) * VE / R**2 - VE * t(phi) / R**2 - t(th) * s(K) * VN / R**2,
    }
    variables = dict(zip(printed, (K, th, g, VN, VE, phi, R), strict=True))
    result = {f"eq08-{name}": Equation(sp.diff(rate, variables[name]), form) for name, form in printed.items()}
    for j, (letter, gyro) in enumerate(zip("xyz", gyros, strict=True)):
        form = -c(g) / c(th) * A_e[j, 1] - s(g) / c(th) * A_e[j, 0] * s(b) + s(g) / c(th) * A_e[j, 2] * c(b)
        result[f"eq08-gyro-{letter}"] = Equation(sp.diff(by_gyro, gyro), form)
    return result


def _gyro_y() -> dict[str, Equation]:
    import sympy as sp

    y = _symbols()
    K, b, rate, U, phi = (y[n] for n in "K beta beta_rate U phi".split())
    A_K, _, _ = _turns(K, 0, 0)
    earth = sp.Matrix([U * sp.cos(phi), U * sp.sin(phi), 0])
    seen = (_pyramid() * (_about_up(b) * A_K * earth + sp.Matrix([0, rate, 0])))[1]
    k_1, k_2 = sp.sqrt(2) * U * sp.cos(phi) / sp.sqrt(3), U * sp.sin(phi) / sp.sqrt(3)
    turned = k_1 * sp.sin(b - K)
    # (14): k_1 sin(b - K) dK = d omega_yb + k_1 sin(b - K) d beta - d beta_rate / sqrt(3)
    by_heading = sp.diff(seen, K)
    return {
        "eq13": Equation(seen, k_1 * sp.cos(b - K) + rate / sp.sqrt(3) + k_2),
        "eq14-heading": Equation(by_heading, turned),
        "eq14-angle": Equation(-sp.diff(seen, b), turned),
        "eq14-rate": Equation(-sp.diff(seen, rate), -1 / sp.sqrt(3) + 0 * turned),
    }


def _mount_off() -> dict[str, Equation]:
    import sympy as sp

    y = _symbols()
    th, g = y["theta"], y["gamma"]
    gyros = sp.Matrix([y["w_xb"], y["w_yb"], y["w_zb"]])
    _, A_theta, A_gamma = _turns(0, th, g)
    ahead, _, abeam = A_theta.T * A_gamma.T * _pyramid().T * gyros
    N, E = sp.symbols("omega_NK omega_EK", positive=True)

    def varied(by):  # of tan K = -omega_EK / omega_NK
        return (-N * sp.diff(abeam, by) + E * sp.diff(ahead, by)) / N**2

    s, c, half = sp.sin, sp.cos, sp.sqrt(sp.Rational(5, 6))
    steep = sp.atan(sp.sqrt(sp.Rational(3, 2)))  # 50.8 deg, printed 51; its complement is printed 39
    flat = sp.pi / 2 - steep
    third, sixth = 1 / sp.sqrt(3), 1 / sp.sqrt(6)
    x, w, z = gyros
    across = half * c(g + steep) * x + third * c(g) * w + half * c(g - steep) * z
    raised = half * s(th) * c(g - flat) * x + third * s(th) * s(g) * w - half * s(th) * c(g + flat) * z
    pitched = (
        (sixth * s(th) + half * c(th) * s(g - flat)) * x
        - (sp.sqrt(2) * third * s(th) + third * c(th) * c(g)) * w
        + (sixth * s(th) - half * c(th) * s(g + flat)) * z
    )
    printed = {
        "gyro-x": -half / N * s(g + steep) + E / N**2 * (-sixth * c(th) + half * s(th) * s(g - flat)),
        "gyro-y": -third / N * s(g) + E / N**2 * (sp.sqrt(2) * third * c(th) - third * s(th) * c(g)),
        "gyro-z": -half / N * s(g - steep) + E / N**2 * (-sixth * c(th) - half * s(th) * s(g + flat)),
        "roll": -across / N + E / N**2 * raised,
        "trim": E / N**2 * pitched,
    }
    by = dict(zip(printed, (x, w, z, g, th), strict=True))
    return {f"eq17-{name}": Equation(varied(by[name]), form) for name, form in printed.items()}


def holds(name: str) -> bool:
    """Whether an equation, or all coefficients whose name begins so, are restored as they follow."""
    found = [equation for key, equation in equations().items() if key == name or key.startswith(f"{name}-")]
    if not found:
        raise KeyError(name)
    return all(equation.holds for equation in found)


def rounding_of_angles() -> float:
    """Largest change of a coefficient of (17) from the printed 51 and 39 degrees, over its amplitude sqrt(5/6)."""
    import math

    return 2 * math.sin(abs(math.radians(51) - math.atan(math.sqrt(1.5))) / 2)
