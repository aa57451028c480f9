"""The models whose formulas were pictures and are lost, rebuilt from the words that remain.

`formulas` holds each as a reading, its coefficients and its inputs; the words fix the number of terms and what each is
called, not the order of the symbols. None of this is a quotation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr, Symbol

AXES = "xyz"


@dataclass(frozen=True)
class Formula:
    """One reconstructed model.

    Attributes
    ----------
    reading : sympy.Expr
        What the sensor reads, or its error.
    coefficients, inputs : tuple of sympy.Symbol
        What calibration finds, and what it is given.
    """

    reading: Expr
    coefficients: tuple[Symbol, ...]
    inputs: tuple[Symbol, ...]

    @property
    def is_linear(self) -> bool:
        """Whether the reading is linear in its coefficients: one multiple regression finds them."""
        import sympy as sp

        return all(sp.diff(self.reading, a, b) == 0 for a in self.coefficients for b in self.coefficients)

    def degree(self, symbol: str) -> int:
        """Degree of the reading as a polynomial in one input."""
        import sympy as sp

        return int(sp.degree(self.reading, next(s for s in self.inputs if s.name == symbol)))

    def has_all_terms(self) -> bool:
        """Whether every coefficient and every input occurs."""
        return {*self.coefficients, *self.inputs} == self.reading.free_symbols


@cache
def formulas() -> dict[str, Formula]:
    """The models by name: one sensor, three sensors, temperature."""
    return _sensors() | _triads() | _temperature()


def _symbols(names: str) -> tuple[Symbol, ...]:
    import sympy as sp

    return sp.symbols(names, seq=True)


def _linear(constant: Symbol, terms: dict[Symbol, Symbol]) -> Formula:
    """A constant and one product of coefficient and input for each entry of `terms`."""
    reading = constant + sum(coefficient * variable for coefficient, variable in terms.items())
    return Formula(reading, (constant, *terms), tuple(terms.values()))


def _sensors() -> dict[str, Formula]:
    a, w = _symbols("a_x a_y a_z"), _symbols("omega_x omega_y omega_z")
    (k0, *components), (d0, *drifts) = _symbols("K_0j K_xj K_yj K_zj"), _symbols("D_0i D_xi D_yi D_zi")
    k, *cosines = _symbols("K_i c_xi c_yi c_zi")
    (bias, scale), (rate,) = _symbols("D_0 K"), _symbols("omega")
    turned = sum(c * component for c, component in zip(cosines, w, strict=True))
    accelerations = sum(d * component for d, component in zip(drifts, a, strict=True))
    return {
        "gyro": _linear(bias, {scale: rate}),
        "accelerometer-axis": _linear(k0, dict(zip(components, a, strict=True))),
        "gyro-axis": Formula(k * (turned + d0 + accelerations), (k, *cosines, d0, *drifts), (*w, *a)),
        # what the six equations of b) leave unknown, the reading in arcsec and the Earth rate taken off
        "gyro-axis-static": _linear(d0, dict(zip(drifts, a, strict=True))),
    }


def _triads() -> dict[str, Formula]:
    """Three sensors, bias, scale factor and two angles each; an angle is counted towards the axis of its product."""

    def readings(kind: str, inputs: tuple[Symbol, ...]) -> Formula:
        reading, coefficients = 0, ()
        (which,) = _symbols("s_0")
        for i, axis in enumerate(AXES):
            others = [j for j in range(3) if j != i]
            angles = _symbols(" ".join(f"E_{kind}{axis}{AXES[j]}" for j in others))
            scale, bias = _symbols(f"K_{kind}{axis} B_{kind}{axis}")
            turned = inputs[i] + sum(angle * inputs[j] for angle, j in zip(angles, others, strict=True))
            reading += which**i * (scale * turned + bias)  # powers of `which` keep the three readings apart
            coefficients += (bias, scale, *angles)
        return Formula(reading, coefficients, (*inputs, which))

    return {
        "accelerometer-triad": readings("a", _symbols("a_x a_y a_z")),
        "gyro-triad": readings("g", _symbols("omega_x omega_y omega_z")),
    }


def _temperature() -> dict[str, Formula]:
    b0, t, rate, reference = _symbols("B_0 T Tdot T_0")
    temperatures, rates = _symbols("T_1 T_2 T_3"), _symbols("Tdot_1 Tdot_2 Tdot_3")
    a, b = _symbols("a_1 a_2 a_3"), _symbols("b_1 b_2 b_3")
    (b1, b2, b3), (k0, k1) = _symbols("k_1 k_2 k_3"), _symbols("K_0 K_1")
    difference = t - reference

    def points(count: int) -> Formula:
        terms = zip((*a[:count], *b[:count]), (*temperatures[:count], *rates[:count]), strict=True)
        return _linear(b0, dict(terms))

    return {
        "bias-temperature": _linear(b0, dict(zip((a[0], b[0]), (t, rate), strict=True))),
        "start-up-short": Formula(b0 + a[0] * difference, (b0, a[0]), (t, reference)),
        "start-up-long": points(2),
        "steady-state": points(3),
        "accelerometer-bias": Formula(
            b0 + b1 * difference + b2 * difference**2 + b3 * difference**3, (b0, b1, b2, b3), (t, reference)
        ),
        "scale-factor": _linear(k0, {k1: t}),
    }


def coefficients_of_both_triads() -> int:
    """Coefficients of three accelerometers and three optical gyros."""
    return sum(len(formulas()[f"{kind}-triad"].coefficients) for kind in ("accelerometer", "gyro"))


def temperature_variables(points: int) -> int:
    """Variables of the regression on `points` temperatures and their rates."""
    name = {2: "start-up-long", 3: "steady-state"}[points]
    return len(formulas()[name].inputs)
