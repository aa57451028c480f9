"""The restored equations against finite differences of the full nonlinear model: numbers, and no symbols on that side.

Where `derivation` sets the print beside what follows by symbols, this sets it beside the package's own mechanisation,
attitudes as matrices and all, evaluated at neighbouring points.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.frames import heading_trim_roll, hull_attitude
from fogkit.gyrocompass.mechanisation import (
    EARTH_RADIUS,
    CompassState,
    Reading,
    geographic_rate,
    gyro_rates,
    state_rate,
)
from fogkit.reproduction.lechang import derivation
from fogkit.reproduction.lechang.requirements import heading_sensitivity
from fogkit.rotation import dcm_from_rotvec

if TYPE_CHECKING:
    from pandas import DataFrame

STEPS = {"angle": 1e-3, "velocity": 100.0, "height": 3e4, "rate": 1e-2, "mount": 1e-2}
"""Steps of the differences: rad, m/s, m, rad/s. The rule errs by their fourth power, rounding by their inverse."""

LETTERS = {"gyro-x": 0, "gyro-y": 1, "gyro-z": 2, "trim": 3, "roll": 4}


def derivative(function: Callable[[float], float], at: float, step: float) -> float:
    """Slope by the five-point rule, exact for a polynomial of the fourth degree."""
    near, far = (function(at + k * step) - function(at - k * step) for k in (1, 2))
    return float((8 * near - far) / (12 * step))


def point(seed: int) -> dict[str, float]:
    """A random attitude, motion and place, under the names of `derivation`'s symbols."""
    rng = np.random.default_rng(seed)
    K, beta = rng.uniform(-1.2, 1.2, 2)
    theta, gamma = rng.uniform(-0.6, 0.6, 2)
    phi, mount = rng.uniform(0.3, 1.2), rng.uniform(-0.4, 0.4)
    v_n, v_e = rng.uniform(-300, 300, 2)
    hull = rng.uniform(-0.3, 0.3, 3)
    gyros = gyro_rates(hull, beta, mount)
    values = {"K": K, "theta": theta, "gamma": gamma, "beta": beta, "phi": phi, "beta_rate": mount}
    values |= {"U": EARTH_RATE, "R": EARTH_RADIUS, "V_N": v_n, "V_E": v_e}
    values |= dict(zip(("w_x", "w_y", "w_z"), hull, strict=True))
    return {name: float(v) for name, v in (values | dict(zip(("w_xb", "w_yb", "w_zb"), gyros, strict=True))).items()}


def _heading_rate(values: dict[str, float], gyros: np.ndarray | None = None) -> float:
    """Rate of heading by the full model."""
    y = values
    rates = np.array([y["w_xb"], y["w_yb"], y["w_zb"]]) if gyros is None else gyros
    state = CompassState(
        heading=y["K"],
        trim=y["theta"],
        roll=y["gamma"],
        velocity=(y["V_N"], 0.0, y["V_E"]),
        lat=y["phi"],
        alt=y["R"] - EARTH_RADIUS,
    )
    return float(state_rate(state, Reading(rates=rates, mount_angle=y["beta"], mount_rate=y["beta_rate"]))[0])


def _angle_rate(values: dict[str, float], which: int) -> float:
    """Rate of an angle of a hull that turns with a constant rate: the attitude as a matrix, its angles read off."""
    C = hull_attitude(values["K"], values["theta"], values["gamma"])
    omega = np.array([values["w_x"], values["w_y"], values["w_z"]])
    return derivative(lambda t: float(heading_trim_roll(C @ dcm_from_rotvec(omega * t))[which]), 0.0, 1e-2)


def _reading_y(values: dict[str, float]) -> float:
    """Reading of gyro y at rest and level."""
    rest = hull_attitude(values["K"], 0.0, 0.0).T @ geographic_rate(values["phi"], np.zeros(3))
    return float(gyro_rates(rest, values["beta"], values["beta_rate"])[1])


def _varied(function: Callable[[dict], float], values: dict[str, float], name: str, step: float) -> float:
    return derivative(lambda x: function({**values, name: x}), values[name], step)


def by_differences(name: str, values: dict[str, float]) -> float:
    """What the model says of an equation or a coefficient of `derivation.equations`, at a point."""
    equation, _, part = name.partition("-")
    if equation == "eq06":
        return _angle_rate(values, ("heading", "trim", "roll").index(part))
    if equation == "eq08":
        if part.startswith("gyro"):
            gyros = np.array([values["w_xb"], values["w_yb"], values["w_zb"]])
            direction = np.eye(3)[LETTERS[part]]
            return derivative(lambda d: _heading_rate(values, gyros + d * direction), 0.0, STEPS["rate"])
        symbol, kind = {
            "heading": ("K", "angle"),
            "trim": ("theta", "angle"),
            "roll": ("gamma", "angle"),
            "velocity-north": ("V_N", "velocity"),
            "velocity-east": ("V_E", "velocity"),
            "lat": ("phi", "angle"),
            "alt": ("R", "height"),
        }[part]
        return _varied(_heading_rate, values, symbol, STEPS[kind])
    if equation == "eq13":
        return _reading_y(values)
    if equation == "eq14":
        symbol = {"heading": "K", "angle": "beta", "rate": "beta_rate"}[part]
        slope = _varied(_reading_y, values, symbol, STEPS["mount"])
        return slope if part == "heading" else -slope  # (14) has these two on its other side
    at = values["K"], values["theta"], values["gamma"], values["phi"]
    return float(heading_sensitivity(*at)[LETTERS[part]])


def by_print(name: str, values: dict[str, float]) -> float:
    """What the print says of it, as restored; (17) times ``cos(K)**2``, to be the change of heading itself."""
    import sympy

    expression = derivation.equations()[name].printed
    if name.startswith("eq17"):
        level = EARTH_RATE * np.cos(values["phi"])
        rest = hull_attitude(values["K"], values["theta"], values["gamma"]).T @ geographic_rate(
            values["phi"], np.zeros(3)
        )
        values = values | dict(zip(("w_xb", "w_yb", "w_zb"), gyro_rates(rest, 0.0, 0.0), strict=True))
        values |= {"omega_NK": level * np.cos(values["K"]), "omega_EK": -level * np.sin(values["K"])}
    symbols = sorted(expression.free_symbols, key=str)
    value = sympy.lambdify(symbols, expression, "math")(*(values[str(s)] for s in symbols))
    return float(value * np.cos(values["K"]) ** 2) if name.startswith("eq17") else float(value)


def comparison(points: int = 4) -> "DataFrame":
    """All restored equations beside both checks.

    Parameters
    ----------
    points : int, optional
        Random points.

    Returns
    -------
    DataFrame
        Index ``equation``; columns ``unreadable`` (what had to be restored, empty if the scan shows it), ``symbols``
        (largest relative difference to what is derived), ``numbers`` (largest difference to finite differences over
        the largest value).
    """
    import pandas as pd

    places, rows = [point(seed) for seed in range(points)], []
    for name, equation in derivation.equations().items():
        printed = np.array([by_print(name, values) for values in places])
        found = np.array([by_differences(name, values) for values in places])
        rows.append(
            {
                "equation": name,
                "unreadable": derivation.UNREADABLE.get(name, ""),
                "symbols": equation.difference,
                "numbers": float(np.abs(found - printed).max() / np.abs(printed).max()),
            }
        )
    return pd.DataFrame(rows).set_index("equation")
