"""The paper's equations (2) to (11), derived by symbols and set beside the print.

`equations` holds for each of them what follows from eq. (1) and what the paper prints; where the two differ their
difference is not zero for any choice of parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr

HALF_PERIODS = (2, 4, 8)
"""Numbers of half-periods for which sums over a regulation period are checked."""


@dataclass(frozen=True)
class Equation:
    """One equation of the paper: what follows from (1), and what is printed.

    Attributes
    ----------
    derived, printed : sympy.Expr
        Right-hand sides.
    """

    derived: Expr
    printed: Expr

    @property
    def holds(self) -> bool:
        """Whether the print is what follows."""
        import sympy

        return sympy.simplify(sympy.expand(sympy.expand_trig(self.derived - self.printed)).rewrite(sympy.cos)) == 0

    @property
    def holds_with_the_other_sign(self) -> bool:
        """Whether the negative of the print is what follows."""
        return Equation(self.derived, -self.printed).holds


@cache
def equations() -> dict[str, Equation]:
    """Equations by the ending of their row in the ledger.

    Returns
    -------
    dict of Equation
        Symbols: depth ``phi_0``, scale factor ``S``, acceleration ``epsilon``, modulation and regulation period ``T_m``
        and ``T_p``, full power 1.
    """
    import sympy as sp

    phi, S, eps, Tm, Tp, t, w0 = sp.symbols("phi_0 S epsilon T_m T_p t omega_0", positive=True)
    d1, d2, w1, w2, t1, t2 = sp.symbols("Delta_1 Delta_2 omega_1 omega_2 t_1 t_2", real=True)
    half, quarter = sp.Rational(1, 2), sp.Rational(1, 4)

    power_1 = _taylor((1 + sp.cos(d1 - phi)) / 2, d1, 3)
    power_2 = _taylor((1 + sp.cos(d2 + phi)) / 2, d2, 3)
    slope = sp.sin(phi) / 2
    difference = (power_1 - power_2) / 2
    in_rates = difference.subs({d1: S * w1, d2: S * w2})
    accelerated = in_rates.subs({w1: eps * t1, w2: eps * t2})
    averaged = in_rates.subs({w1: eps * (t1 + Tp / 2), w2: eps * (t2 + Tp / 2)})

    def second_degree(expression):
        """Its part of second degree in the acceleration, over the slope of the linear term in rate."""
        return sp.expand(expression).coeff(eps, 2) * eps**2 / (slope * S)

    one_pair = second_degree(accelerated)
    one_pair_averaged = second_degree(averaged).subs(t2, t1 + Tm / 2)
    cot = sp.cot(phi)
    increment = w0 + eps * t
    mean = sp.integrate(increment, (t, 0, Tp)) / Tp
    next_increment = increment.subs(t, Tp) - mean + eps * t

    result = {
        "eq02": Equation(
            power_1,
            half * (1 + sp.cos(phi) + sp.sin(phi) * d1 - half * sp.cos(phi) * d1**2 - sp.sin(phi) * d1**3 / 6),
        ),
        "eq03": Equation(
            power_2,
            half * (1 + sp.cos(phi) - sp.sin(phi) * d2 - half * sp.cos(phi) * d2**2 + sp.sin(phi) * d2**3 / 6),
        ),
        "demod-phase": Equation(
            difference,
            slope * (half * (d1 + d2) - quarter * cot * (d1**2 - d2**2) - (d1**3 + d2**3) / 12),
        ),
        "demod-rate": Equation(
            in_rates,
            slope * S * (half * (w1 + w2) - quarter * cot * S * (w1**2 - w2**2) - S**2 * (w1**3 + w2**3) / 12),
        ),
        "eq04": Equation(
            accelerated,
            slope
            * S
            * (
                half * eps * (t1 + t2)
                - quarter * cot * S * eps**2 * (t1**2 - t2**2)
                - S**2 * eps**3 * (t1**3 + t2**3) / 12
            ),
        ),
        "eq05": Equation(one_pair, -quarter * cot * S * eps**2 * (t1**2 - t2**2)),
        "mean-increment": Equation(mean, w0 + eps * Tp / 2),
        "eq10": Equation(next_increment, eps * Tp / 2 + eps * t),
        "omega0": Equation(sp.solve(sp.Eq(increment, next_increment), w0)[0], eps * Tp / 2),
        "eq05-averaged": Equation(
            one_pair_averaged,
            (-quarter * cot * S * eps**2 * (t1**2 - t2**2 - Tm * Tp / 2)).subs(t2, t1 + Tm / 2),
        ),
    }
    for k in HALF_PERIODS:
        result |= _sums(k, one_pair, second_degree(averaged), (t1, t2), (phi, S, eps, Tm, Tp))
    return result


def _taylor(expression: Expr, variable: Expr, degree: int) -> Expr:
    return expression.series(variable, 0, degree + 1).removeO()


def _sums(k: int, one_pair: Expr, one_pair_averaged: Expr, pair, symbols) -> dict[str, Equation]:
    """The equations that sum over the k half-periods of a regulation period."""
    import sympy as sp

    phi, S, eps, Tm, Tp = symbols
    times = sp.symbols(f"t_1:{k + 1}", real=True)
    pairs = list(zip(times[::2], times[1::2], strict=True))
    factor = sp.cot(phi) * S * eps**2
    squares = sum(a**2 - b**2 for a, b in pairs)
    spaced = {times[i]: times[0] + i * Tm / 2 for i in range(1, k)}
    middles = {times[i]: (i + sp.Rational(1, 2)) * Tm / 2 for i in range(k)}
    length = {Tp: k * Tm / 2}  # a regulation period is k half-periods

    def mean(pair_error):
        return sum(pair_error.subs(dict(zip(pair, ab, strict=True)), simultaneous=True) for ab in pairs) * 2 / k

    printed_sum = -sp.Rational(2, k) * Tm / 2 * sum(times)
    return {
        f"eq06 k={k}": Equation(mean(one_pair), -factor * squares / (2 * k)),
        f"eq07-sum k={k}": Equation((squares * 2 / k).subs(spaced), printed_sum.subs(spaced)),
        f"eq07-limit k={k}": Equation((squares * 2 / k).subs(middles), (-Tm * Tp / 2).subs(length)),
        f"eq08 k={k}": Equation(mean(one_pair).subs(middles), (-factor * Tm * Tp / 8).subs(length)),
        f"eq11 k={k}": Equation(
            mean(one_pair_averaged).subs(middles).subs(length), (-factor * Tm * Tp / 4).subs(length)
        ),
    }


def holds(name: str) -> bool:
    """Whether an equation is printed right, for every number of half-periods if it has one."""
    return all(equation.holds for equation in _named(name))


def holds_with_the_other_sign(name: str) -> bool:
    """Whether the negative of an equation's print is right, for every number of half-periods if it has one."""
    return all(equation.holds_with_the_other_sign for equation in _named(name))


def _named(name: str) -> list[Equation]:
    found = [equation for key, equation in equations().items() if key.split(" ")[0] == name]
    if not found:
        raise KeyError(name)
    return found


def linear_term_is_the_mean() -> bool:
    """Whether the first-degree part of the demodulated difference is the mean deviation times the slope."""
    import sympy as sp

    difference = equations()["demod-phase"].derived
    phi, d1, d2, x = (*sp.symbols("phi_0", positive=True, seq=True), *sp.symbols("Delta_1 Delta_2 x", real=True))
    first = sp.expand(difference.subs({d1: x * d1, d2: x * d2}, simultaneous=True)).coeff(x, 1)
    return sp.simplify(first - sp.sin(phi) / 2 * (d1 + d2) / 2) == 0


def parity_in_acceleration(degree: int = 8) -> dict[int, int]:
    """Sign that each power of the acceleration in the demodulated difference takes when the acceleration is reversed.

    Parameters
    ----------
    degree : int, optional
        Degree to which eq. (1) is expanded.

    Returns
    -------
    dict of int
        Power to 1 (keeps its sign) or -1; powers whose coefficient vanishes are left out.
    """
    import sympy as sp

    phi, S, t1, t2 = sp.symbols("phi_0 S t_1 t_2", positive=True)
    eps = sp.symbols("epsilon", real=True)
    first = _taylor((1 + sp.cos(eps - phi)) / 2, eps, degree).subs(eps, S * eps * t1)
    second = _taylor((1 + sp.cos(eps + phi)) / 2, eps, degree).subs(eps, S * eps * t2)
    difference = sp.expand((first - second) / 2)
    signs = {}
    for power in range(1, degree + 1):
        term = difference.coeff(eps, power) * eps**power
        if sp.simplify(term) != 0:
            signs[power] = 1 if sp.simplify(term.subs(eps, -eps) - term) == 0 else -1
    return signs
