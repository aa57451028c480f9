"""The paper's simulation rerun: its figures as tables, its means, and the choices that it leaves open.

Every mean is taken by `fogkit.optics.measure.simulated_drift` over 120 cycles unless a function says otherwise. Drifts
are in deg/h, accelerations in deg/s^2, as in the paper.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit.campaign import map_cases
from fogkit.optics import ClosedLoopGyro, drift
from fogkit.optics.interferometer import power
from fogkit.optics.measure import nonlinear_error, simulated_drift, windowed_mean
from fogkit.optics.motion import AngularOscillation
from fogkit.optics.simulate import run
from fogkit.reproduction.miklyashev.instruments import (
    DEVICES,
    FIGURE_1_ACCELERATION,
    LENGTH,
    MEASURED_ACCELERATIONS,
    OSCILLATION_FREQUENCY,
    SIMULATED,
    SIMULATED_ACCELERATIONS,
    make_gyro,
)
from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, MICROMETRE

if TYPE_CHECKING:
    import pandas as pd

CYCLES = 120
PRINTED_MEAN = (0.2135, 0.2145)
"""Means that round to the print, deg/h."""


@cache
def mean_drift(
    gyro: ClosedLoopGyro = SIMULATED,
    acceleration: float = FIGURE_1_ACCELERATION,
    degree: int | None = None,
    frequency: float = OSCILLATION_FREQUENCY,
) -> float:
    """Mean drift of a gyro under angular oscillation, simulated, deg/h, with its sign.

    Parameters
    ----------
    gyro : ClosedLoopGyro, optional
        The gyro.
    acceleration : float, optional
        Amplitude of the angular acceleration, rad/s^2.
    degree : int, optional
        Degree of the interferometer's Taylor polynomial; None is the exact response.
    frequency : float, optional
        Frequency of the oscillation, Hz.
    """
    oscillation = AngularOscillation(acceleration=acceleration, frequency=frequency)
    return simulated_drift(gyro, oscillation, CYCLES / frequency, degree=degree).drift / DEG_PER_HOUR


def figure_1() -> pd.DataFrame:
    """Fig. 1: error over one settled period of the oscillation at 5000 deg/s^2.

    Returns
    -------
    pandas.DataFrame
        Index ``time``, s, from zero rate on; columns ``second_degree`` (drawn solid) and ``full`` (dashed), deg/h:
        reading of the nonlinear loop less that of the linear one.
    """
    import pandas as pd

    oscillation = AngularOscillation(acceleration=FIGURE_1_ACCELERATION, frequency=OSCILLATION_FREQUENCY)
    start = 3 / OSCILLATION_FREQUENCY
    columns = {}
    for name, degree in (("second_degree", 2), ("full", None)):
        error = nonlinear_error(SIMULATED, oscillation, start + 1 / OSCILLATION_FREQUENCY, degree=degree)
        settled = error.time >= start
        columns[name] = pd.Series(error.rate[settled] / DEG_PER_HOUR, index=error.time[settled] - start)
    return pd.DataFrame(columns).rename_axis("time")


def figure_2() -> pd.DataFrame:
    """Fig. 2: mean drift of both devices against the amplitude of the acceleration, with sign.

    Returns
    -------
    pandas.DataFrame
        Index ``acceleration``, deg/s^2; columns ``<device>, formula`` (half of the corrected eq. (11)), ``second
        degree`` and ``full``, deg/h.
    """
    import pandas as pd

    table = {}
    for device, gyro in DEVICES.items():
        table[device, "formula"] = drift.steady_drift(gyro, MEASURED_ACCELERATIONS) / 2 / DEG_PER_HOUR
        for name, degree in (("second degree", 2), ("full", None)):
            table[device, name] = _means(gyro, MEASURED_ACCELERATIONS, degree)
    index = pd.Index(MEASURED_ACCELERATIONS / DEG_PER_SECOND_SQUARED, name="acceleration")
    return pd.DataFrame(table, index=index)


def mean_differences() -> pd.DataFrame:
    """Mean drift with the second degree alone and with the whole nonlinearity, over the range that the paper simulates.

    Returns
    -------
    pandas.DataFrame
        Index ``acceleration``, deg/s^2; columns ``second_degree``, ``full``, deg/h, and ``difference``, percent of the
        second-degree mean.
    """
    import pandas as pd

    table = pd.DataFrame(
        {
            "second_degree": _means(SIMULATED, SIMULATED_ACCELERATIONS, 2),
            "full": _means(SIMULATED, SIMULATED_ACCELERATIONS, None),
        },
        index=pd.Index(SIMULATED_ACCELERATIONS / DEG_PER_SECOND_SQUARED, name="acceleration"),
    )
    table["difference"] = 100 * (table.full / table.second_degree - 1)
    return table


def acceleration_where_models_differ(percent: float = 0.1) -> float:
    """Amplitude at which the full mean drift differs from the second-degree one by `percent`, deg/s^2."""
    from scipy.optimize import brentq

    def excess(log_acceleration: float) -> float:
        acceleration = np.exp(log_acceleration)
        ratio = mean_drift(SIMULATED, acceleration, None) / mean_drift(SIMULATED, acceleration, 2)
        return 100 * abs(ratio - 1) - percent

    bounds = np.log(SIMULATED_ACCELERATIONS[[2, -1]])
    return float(np.exp(brentq(excess, *bounds, xtol=1e-4))) / DEG_PER_SECOND_SQUARED


def difference_outside_the_loop(acceleration: float) -> float:
    """Difference of the means if higher degrees act on the demodulation only and not through the loop, percent.

    The residual phase is that of the linear loop, eq. (10), and is demodulated with the exact response and with the
    second degree: the other way in which the paper's comparison may have been made.

    Parameters
    ----------
    acceleration : float
        Amplitude of the angular acceleration, rad/s^2.
    """
    oscillation = AngularOscillation(acceleration=acceleration, frequency=OSCILLATION_FREQUENCY)
    loop, coil = SIMULATED.loop, SIMULATED.coil
    linear = run(SIMULATED, oscillation, CYCLES / OSCILLATION_FREQUENCY, degree=1)
    rates = oscillation.sample(0, linear.rate.size * loop.half_periods, loop.half_period)
    residual = coil.phase(rates - np.repeat(linear.rate, loop.half_periods))
    bias = np.tile(loop.bias_pattern[0], linear.rate.size) * loop.depth
    means = {
        name: windowed_mean(-np.sign(bias) * light)
        for name, light in (
            ("full", power(residual + bias)),
            ("second", _second_degree(residual, bias)),
            ("linear", 0.5 * (1 + np.cos(bias) - np.sin(bias) * residual)),
        )
    }
    return float(100 * ((means["full"] - means["linear"]) / (means["second"] - means["linear"]) - 1))


def _second_degree(residual: np.ndarray, bias: np.ndarray) -> np.ndarray:
    return 0.5 * (1 + np.cos(bias) - np.sin(bias) * residual - 0.5 * np.cos(bias) * residual**2)


def wavelengths_that_round_to_the_print() -> tuple[float, float]:
    """Wavelengths between which the many-cycle mean at 5000 deg/s^2 rounds to the printed 0.214 deg/h, um.

    All else as stated: the drift is inversely proportional to the wavelength but for a part in 1e5.
    """
    product = abs(mean_drift()) * SIMULATED.coil.wavelength / MICROMETRE
    low, high = (product / bound for bound in reversed(PRINTED_MEAN))
    return low, high


def open_choices() -> pd.DataFrame:
    """Mean drift at 5000 deg/s^2 for the choices that the paper does not state, against its 0.214 deg/h.

    Returns
    -------
    pandas.DataFrame
        One row per combination: ``wavelength``, um; ``half_period``: one sample of 200 kHz or the transit time of a
        refractive index; ``start``: phase of the oscillation at which the record and the loop begin; ``window``; the
        mean ``drift`` with the exact response, deg/h; ``prints``: whether its size rounds to the print.
    """
    import pandas as pd

    rows = []
    for wavelength in (1.31, 1.53, 1.54, 1.55, 1.56):
        for name, half_period in _half_periods().items():
            gyro = make_gyro(wavelength=wavelength * MICROMETRE, half_period=half_period)
            for start, window, value in _means_of_windows(gyro):
                rows.append((wavelength, name, start, window, value))
    table = pd.DataFrame(rows, columns=["wavelength", "half_period", "start", "window", "drift"])
    table["prints"] = table.drift.abs().between(*PRINTED_MEAN)
    return table


def index_for_whole_half_periods() -> float:
    """Refractive index at which 16 transit times fill a regulation period of device 1 exactly."""
    from fogkit.constants import SPEED_OF_LIGHT

    return SIMULATED.loop.half_period * SPEED_OF_LIGHT / LENGTH


def _half_periods() -> dict[str, float]:
    """The paper's sample, and transit times of usual fibres."""
    from fogkit.optics import Coil

    indices = (1.45, 1.468)
    transit = {f"transit time, index {n}": Coil(length=LENGTH, diameter=0.1, index=n).transit_time for n in indices}
    return {"sample of 200 kHz": SIMULATED.loop.half_period} | transit


def _means_of_windows(gyro: ClosedLoopGyro):
    """Start, window and mean, deg/h, for the ways in which one might take it."""
    yield "any", f"{CYCLES} cycles, weighted", mean_drift(gyro)
    steps = int(np.ceil(1 / OSCILLATION_FREQUENCY / gyro.loop.regulation_period))
    for start, phase in (("zero rate", 0.0), ("largest rate", np.pi / 2)):
        oscillation = AngularOscillation(
            acceleration=FIGURE_1_ACCELERATION, frequency=OSCILLATION_FREQUENCY, phase=phase
        )
        error = nonlinear_error(gyro, oscillation, steps * gyro.loop.regulation_period)
        for count in (steps - 1, steps):
            yield start, f"first {count} regulation periods", error.rate[:count].mean() / DEG_PER_HOUR


def _means(gyro: ClosedLoopGyro, accelerations: np.ndarray, degree: int | None) -> list[float]:
    cases = [{"gyro": gyro, "acceleration": float(a), "degree": degree} for a in accelerations]
    with ThreadPoolExecutor() as pool:
        return map_cases(mean_drift, cases, executor=pool)
