"""A. V. Miklyashev (2019), error of a fibre-optic gyroscope at angular oscillations: instruments, proofs, simulation.

`values` maps each row of the ledger to what computes it.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fogkit.claims import Proof
from fogkit.optics import drift, interferometer, simulate
from fogkit.optics.compensation import InsideLoop
from fogkit.optics.measure import simulated_drift
from fogkit.optics.motion import AngularOscillation, Ramp
from fogkit.reproduction.miklyashev import derivation, simulation
from fogkit.reproduction.miklyashev.instruments import (
    ASSUMED_WAVELENGTH,
    DEVICES,
    FIGURE_1_ACCELERATION,
    MEASURED_ACCELERATIONS,
    OSCILLATION_FREQUENCY,
    RUN_DURATION,
    SIMULATED,
    SIMULATED_ACCELERATIONS,
    make_gyro,
)
from fogkit.reproduction.miklyashev.simulation import figure_1, figure_2, mean_drift
from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, KILOHERTZ, MINUTE

__all__ = [
    "ASSUMED_WAVELENGTH",
    "DEVICES",
    "FIGURE_1_ACCELERATION",
    "MEASURED_ACCELERATIONS",
    "OSCILLATION_FREQUENCY",
    "RUN_DURATION",
    "SIMULATED",
    "SIMULATED_ACCELERATIONS",
    "derivation",
    "figure_1",
    "figure_2",
    "make_gyro",
    "mean_drift",
    "simulation",
    "values",
]

ACCELERATION = 50.0
"""Constant acceleration for checks of the loop's steady state, rad/s^2."""

_DERIVED = (
    "eq02 eq03 demod-phase demod-rate eq04 eq05 eq06 eq07-sum eq07-limit mean-increment eq10 omega0 eq05-averaged"
).split()


def values() -> dict[str, Callable[[], Any] | Any]:
    """What computes each row of the ledger, by row id; see `fogkit.claims`."""
    rows = _derivation() | _loop() | _simulation() | _parameters() | _conclusions()
    return {f"miklyashev-{name}": value for name, value in rows.items()}


def _derivation() -> dict:
    return {name: (lambda name=name: derivation.holds(name)) for name in _DERIVED} | {
        "deviation-symbol": _deviation_symbol,
        "linear-term": derivation.linear_term_is_the_mean,
        "sign-even": lambda: derivation.parity_in_acceleration()[2] == 1,
        "sign-odd": lambda: derivation.parity_in_acceleration()[3] == -1,
        "even-remain": lambda: all(
            (sign == 1) == (power % 2 == 0) for power, sign in derivation.parity_in_acceleration().items()
        ),
        "eq08": lambda: Proof(printed=derivation.holds("eq08"), corrected=derivation.holds_with_the_other_sign("eq08")),
        "eq11": _eq11,
        "doubling": _doubling,
    }


def _loop() -> dict:
    return {
        "intro-linearity": lambda: abs(mean_drift()) > 0.1 and abs(mean_drift(degree=1)) < 1e-9,
        "premise-from-zero": lambda: bool(np.isclose(_settled_ramp()[0], ACCELERATION * _period() / 2, rtol=1e-9)),
        "eq09": _residual_is_a_straight_line,
        "steady-state": _steady_state,
        "bias-shift": _bias_shift,
    }


def _simulation() -> dict:
    return {
        "sim-depth": lambda: Proof(
            printed=_mean_rounds_near_print(3 * np.pi / 2), corrected=_mean_rounds_near_print(3 * np.pi / 4)
        ),
        "fig1": lambda: float(figure_1().second_degree.abs().max()),
        "fig1-difference": _fig1_difference,
        "sim-mean-drift": lambda: abs(mean_drift()),
        "sim-mean-drift-second": lambda: abs(mean_drift(degree=2)),
        "sim-mean-difference": lambda: _difference(FIGURE_1_ACCELERATION),
        "sim-mean-difference-range": lambda: float(simulation.mean_differences().difference.abs().max()),
        "sim-second-degree-dominates": lambda: bool(simulation.mean_differences().difference.abs().max() < 1),
        "sim-confirms-eq11": lambda: abs(mean_drift(degree=2) / _half_of_eq11() - 1) < 1e-3,
        "fig2-sign": lambda: all(drift.steady_drift(gyro, 1.0) < 0 for gyro in DEVICES.values()),
        "fig2-device1": lambda: mean_drift(DEVICES["device 1"], float(MEASURED_ACCELERATIONS[-1])),
        "fig2-device2": lambda: mean_drift(DEVICES["device 2"], float(MEASURED_ACCELERATIONS[-1])),
    }


def _parameters() -> dict:
    one, two = DEVICES.values()
    return {
        "sim-accel-min": SIMULATED_ACCELERATIONS[0] / DEG_PER_SECOND_SQUARED,
        "sim-accel-max": SIMULATED_ACCELERATIONS[-1] / DEG_PER_SECOND_SQUARED,
        "sim-frequency": OSCILLATION_FREQUENCY,
        "sim-sampling": 1 / SIMULATED.loop.half_period / KILOHERTZ,
        "sim-length": SIMULATED.coil.length,
        "sim-diameter": SIMULATED.coil.diameter * 1e3,
        "sim-feedback-rate": 1 / SIMULATED.loop.regulation_period,
        "fig1-accel": FIGURE_1_ACCELERATION / DEG_PER_SECOND_SQUARED,
        "exp-devices": float(len(DEVICES)),
        "exp-length": one.coil.length,
        "dev1-depth": one.loop.depth,
        "dev1-rate": 1 / one.loop.regulation_period / KILOHERTZ,
        "dev2-depth": two.loop.depth,
        "dev2-rate": 1 / two.loop.regulation_period / KILOHERTZ,
        "exp-accel-max": MEASURED_ACCELERATIONS[-1] / DEG_PER_SECOND_SQUARED,
        "exp-frequency": OSCILLATION_FREQUENCY,
        "exp-duration": np.mean(RUN_DURATION) / MINUTE,
    }


def _conclusions() -> dict:
    return {
        "concl-acceleration": _depends_on_acceleration_alone,
        "concl-second-degree": _bias_shift,
        "concl-loop": lambda: abs(mean_drift(degree=2) / _half_of_eq11() - 1) < 1e-3 and abs(mean_drift()) > 0.1,
        "concl-compensation": _compensation_removes_most,
        "concl-compensation-necessary": lambda: (
            not (_is_removed(make_gyro(bias_order="alternating")) and _is_removed(make_gyro(depth=np.pi / 2)))
        ),
    }


def _deviation_symbol() -> Proof:
    """Whether (2) and (3) approach (1) with a rate, and with a phase, in place of the deviation."""
    depth, phase = SIMULATED.loop.depth, 1e-2
    rate = float(SIMULATED.coil.rate(phase))

    def approaches(deviation: float) -> bool:
        error = interferometer.taylor_power(deviation, -depth, 3) - interferometer.power(phase - depth)
        return bool(abs(error) < phase**4 / 48)  # the remainder of the series

    return Proof(printed=approaches(rate), corrected=approaches(phase))


def _doubling() -> float:
    """Second-degree error in the steady state over that of a first regulation period from rest, simulated."""
    errors = []
    for sign in (1, -1):
        motion = Ramp(acceleration=sign * FIGURE_1_ACCELERATION)
        second, linear = (
            simulate.run(SIMULATED, motion, 100 * _period(), degree=degree, initial_rate=0.0) for degree in (2, 1)
        )
        # the residual of the first period is off by its own error; the late reading by that of the steady state
        errors.append((second.residual[0] - linear.residual[0], second.rate[-1] - linear.rate[-1]))
    first, late = np.sum(errors, axis=0)
    return float(late / first)


def _residual_is_a_straight_line() -> bool:
    """Whether the residual phase of the loop as a `control` system grows by the acceleration within a period."""
    import control

    from fogkit.optics.systems import nonlinear_system

    k, step = SIMULATED.loop.half_periods, SIMULATED.loop.half_period
    rates = Ramp(acceleration=ACCELERATION).sample(0, 6 * k, step)
    inputs = np.vstack([rates, np.zeros_like(rates)])
    response = control.input_output_response(nonlinear_system(SIMULATED, degree=1), np.arange(6 * k) * step, inputs)
    residual = SIMULATED.coil.rate(response.outputs[1]).reshape(6, k)
    return bool(np.allclose(np.diff(residual, axis=1), ACCELERATION * step, rtol=1e-6))


def _eq11() -> Proof:
    """Sign and size of (11): by symbols, and by the simulated loop under constant acceleration of either sign."""
    simulated = 0.5 * sum(_settled_error(sign * FIGURE_1_ACCELERATION) for sign in (1, -1))
    loop = SIMULATED.loop
    size = (
        SIMULATED.coil.sagnac_scale_factor
        * FIGURE_1_ACCELERATION**2
        * (2 * loop.half_period)
        * loop.regulation_period
        / (4 * np.tan(loop.depth))
    )
    return Proof(
        printed=derivation.holds("eq11") or bool(np.isclose(simulated, -size, rtol=1e-3)),
        corrected=derivation.holds_with_the_other_sign("eq11") and bool(np.isclose(simulated, size, rtol=1e-3)),
    )


def _settled_error(acceleration: float) -> float:
    """Second-degree error of the simulated gyro in the steady state under constant acceleration, rad/s."""
    duration = 100 * SIMULATED.loop.regulation_period
    motion = Ramp(acceleration=acceleration)
    second, linear = (simulate.run(SIMULATED, motion, duration, degree=degree) for degree in (2, 1))
    return float(second.rate[-1] - linear.rate[-1])


def _period() -> float:
    return SIMULATED.loop.regulation_period


def _settled_ramp() -> np.ndarray:
    """Uncompensated rate at the begin of each half-period of a late regulation period of the linear loop, rad/s."""
    motion = Ramp(acceleration=ACCELERATION)
    record = simulate.run(SIMULATED, motion, 50 * _period(), degree=1)
    k, step = SIMULATED.loop.half_periods, SIMULATED.loop.half_period
    rates = motion.sample(49 * k, k, step) - ACCELERATION * step / 2  # from the middle of the half-period to its begin
    return rates - record.rate[-1]


def _steady_state() -> bool:
    """Whether the mean residual is that of (10) from the second period on, whatever the register holds at first."""
    residuals = [
        simulate.run(SIMULATED, Ramp(acceleration=ACCELERATION), 5 * _period(), degree=1, initial_rate=start).residual
        for start in (-1.0, 0.0, 0.3)
    ]
    return all(np.allclose(late[1:], ACCELERATION * _period(), rtol=1e-9) for late in residuals)


def _bias_shift() -> bool:
    """Whether odd degrees alone leave no mean error and the second does; at a depth of pi/2 even ones have no part."""
    odd = mean_drift(make_gyro(depth=np.pi / 2), degree=3)
    return abs(odd) < 1e-6 and abs(mean_drift(degree=1)) < 1e-9 and abs(mean_drift(degree=2)) > 0.1


def _half_of_eq11() -> float:
    return float(drift.steady_drift(SIMULATED, FIGURE_1_ACCELERATION)) / 2 / DEG_PER_HOUR


def _difference(acceleration: float) -> float:
    """Full mean drift against the second-degree one, percent."""
    return 100 * abs(mean_drift(SIMULATED, acceleration, None) / mean_drift(SIMULATED, acceleration, 2) - 1)


def _fig1_difference() -> bool:
    curves = figure_1()
    return bool((curves.full - curves.second_degree).abs().max() < 0.1 * curves.second_degree.abs().max())


def _mean_rounds_near_print(depth: float) -> bool:
    """Whether (11) at a depth gives the printed 0.214 deg/h within the 5 % that wavelength and index leave open."""
    gyro = SIMULATED
    size = (
        gyro.coil.sagnac_scale_factor * FIGURE_1_ACCELERATION**2 * gyro.loop.half_period * gyro.loop.regulation_period
    )
    return bool(np.isclose(abs(size / np.tan(depth)) / 4 / DEG_PER_HOUR, 0.214, rtol=0.05))


def _depends_on_acceleration_alone() -> bool:
    """Whether the drift grows with the square of the acceleration and is the same at 30 and 120 Hz, within 1 %."""
    once, twice = mean_drift(), mean_drift(acceleration=2 * FIGURE_1_ACCELERATION)
    others = [mean_drift(frequency=frequency) for frequency in (30.0, 120.0)]
    return bool(np.allclose([twice / 4, *others], once, rtol=0.01))


def _compensation_removes_most() -> bool:
    """Whether the correction inside the loop leaves less than a tenth, at 5000 and at 50 000 deg/s^2."""
    shares = []
    for acceleration in (FIGURE_1_ACCELERATION, float(SIMULATED_ACCELERATIONS[-1])):
        oscillation = AngularOscillation(acceleration=acceleration, frequency=OSCILLATION_FREQUENCY)
        left = simulated_drift(SIMULATED, oscillation, 2.0, compensation=InsideLoop()).drift / DEG_PER_HOUR
        shares.append(abs(left / mean_drift(SIMULATED, acceleration)))
    return max(shares) < 0.1


def _is_removed(gyro) -> bool:
    """Whether a gyro has less than a hundredth of the drift of the simulated one, with the exact response."""
    return abs(mean_drift(gyro)) < 0.01 * abs(mean_drift())
