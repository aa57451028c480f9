"""D. V. Volynskii et al. (2011), bench calibration of fibre-optic gyros: stated numbers, proofs, error budget.

`values` maps the rows of the ledger to what computes them.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fogkit.calibration import requirements
from fogkit.claims import Proof
from fogkit.imu.constructions import TRIHEDRAL_ALPHA, TRIHEDRAL_BETA
from fogkit.reproduction.volynskii import bench, budget, derivation, instruments, simulation
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, HOUR, MINUTE, PERCENT, REVOLUTION

__all__ = ["bench", "budget", "derivation", "instruments", "simulation", "values"]

_DERIVED = (
    "eq02 eq03 eq04 eq05 eq06 eq06-unit eq07 eq07-scale eq08 four-arbitrary eq09 eq10 two-one-turn eq11 eq13 eq13-u "
    "eq14 eq15-cos eq15-sin eq16 eq17 eq18 eq19 eq20 eq21 eq22 eq23"
).split()

_FIGURE_REFERENCES = {  # what the text speaks of: the figure it names, the figure it means
    "fig-type1": ("frames of the plain construction", "1a", None),
    "fig-type2": ("frames of the block construction", "2", "1b"),
    "fig-type3": ("frames of the trihedral construction", "2", None),
    "fig-eq04": ("frames of the block construction", "1a", "1b"),
    "fig-eq06": ("input axes against their nominal directions", "2", "3"),
    "fig-table": ("axes of the table and of the unit", "4", None),
}


def values() -> dict[str, Callable[[], Any] | Any]:
    """What computes each row of the ledger, by row id; see `fogkit.claims`."""
    rows = _derivation() | _figures() | _requirements() | _method() | _accuracy() | _results() | _parameters()
    return {f"volynskii-{name}": value for name, value in rows.items()}


def _derivation() -> dict:
    return {name: (lambda name=name: derivation.proof(name)) for name in _DERIVED} | {
        "eq08-yz": lambda: derivation.proof("eq08"),  # its row of A_g is arbitrary
        "two-yz": lambda: derivation.proof("two-one-turn"),
        "bias-no-scale": lambda: derivation.proof("eq08"),
        "eq14-index": _eq14_index,
        "eq17-source": _eq17_source,
        "eq20-denominator": _eq20_denominator,
        "eq22-sqrt2": _eq22_sqrt2,
        "axis-3-angle": lambda: Proof(
            printed=instruments.TABLE_ANGLES[instruments.STAGE_2_AXES["z"]] == "gamma_c",
            corrected=instruments.TABLE_ANGLES[instruments.STAGE_2_AXES["z"]] == "gamma_c1",
        ),
    }


def _figures() -> dict:
    shows = instruments.FIGURES
    return {
        name: Proof(printed=shows[named] == what, corrected=None if meant is None else shows[meant] == what)
        for name, (what, named, meant) in _FIGURE_REFERENCES.items()
    }


def _requirements() -> dict:
    drift, slow, fast = instruments.GYRO_DRIFT, *instruments.TURN_RATES
    small = (1 - 0.5e-6, 1 + 0.5e-6)
    return {
        "asymmetry-drifts": lambda: (
            abs(simulation.rocking_drift(*small)) > 0.03 * DEG_PER_HOUR
            and abs(simulation.rocking_drift(1, 1)) < 1e-9 * DEG_PER_HOUR
        ),
        "turn-drifts": _turn_drifts,
        "separate": lambda: (
            abs(simulation.rocking_drift(*small, known=small)) < 1e-6 * abs(simulation.rocking_drift(*small))
        ),
        "rocking-rate": lambda: simulation.rocking_amplitude() / DEG_PER_SECOND,
        "rocking-rate-dph": lambda: instruments.MAX_RATE / DEG_PER_HOUR,
        "req-asymmetry": lambda: requirements.asymmetry_from_drift(drift, instruments.MAX_RATE),
        "req-scale-slow": lambda: requirements.scale_error_from_drift(drift, slow),
        "req-scale-fast": lambda: requirements.scale_error_from_drift(drift, fast),
        "req-misalignment": _misalignment,
        "req-mounting": _misalignment,
        "type2-axes": _misalignment,
        "concl-mounting": _misalignment,
        "table-drift": lambda: drift / 5 / DEG_PER_HOUR,
        "table-unreal": lambda: bool(
            requirements.drift_from_table_stability(instruments.TABLE_RATE_STABILITY, instruments.MAX_RATE, margin=1)
            > 100 * instruments.TABLE_DRIFT
        ),
        "angle-instead": lambda: bool(_readout_error(3 * ARCSEC) < _required_scale_error() / 3),
        "req-azimuth": lambda: requirements.azimuth_from_rate_error(instruments.TABLE_DRIFT, 0.0) / ARCSEC,
        "azimuth-rate": lambda: simulation.worst_azimuth_rate(instruments.AZIMUTH_ERRORS[1]) / DEG_PER_HOUR,
        "req-readout": lambda: bool(_readout_error(3 * ARCSEC) < _required_asymmetry()),
        "concl-readout": lambda: bool(_readout_error(ARCSEC) < _required_scale_error() / 3),
    }


def _method() -> dict:
    limit = instruments.MISALIGNMENT_LIMIT
    return {
        "trihedral-alpha": TRIHEDRAL_ALPHA / DEG,
        "trihedral-beta": TRIHEDRAL_BETA / DEG,
        "eq06-three": lambda: simulation.rows_extend_to_rotations(limit),
        "whole-turns": lambda: (
            abs(simulation.modulated_earth_rate(36))
            < 1e-6 * DEG_PER_HOUR
            < 0.01 * DEG_PER_HOUR
            < abs(simulation.modulated_earth_rate(36.5))
        ),
        "small-angles": max(abs(cell["mean"]) for cell in instruments.TABLE_3.values()),
        "eq12-accuracy": lambda: derivation.terms_at("cos", 2, limit),
        "rates-near-max": _rates_near_max,
        "angle-limit": lambda: Proof(
            printed=_one_digit(derivation.terms_at("cos", 2, 5 * ARCSEC)) == 2e-6,
            corrected=_one_digit(derivation.terms_at("cos", 2, 5 * ARCMIN)) == 2e-6,
        ),
        "eq15-cos-remainder": lambda: derivation.terms_at("cos", 4, limit),
        "eq15-sin-remainder": lambda: derivation.terms_at("sin", 5, limit),
        "eq15-quadratic": lambda: derivation.terms_at("cos", 2, limit),
        "eq15-cubic": lambda: round(np.log10(derivation.terms_at("sin", 3, limit))) == -9,
        "second-enough": _second_enough,
        "type3-tilt": lambda: simulation.trihedral_brings_upright()["y"],
        "type2-reduces": lambda: bench.recovers("block"),
        "type3-operations": lambda: bench.recovers("trihedral"),
        "unified": lambda: all(bench.recovers(name) for name in ("plain", "block", "trihedral")),
        "type3-120-240": lambda: all(simulation.trihedral_brings_upright().values()),
    }


def _accuracy() -> dict:
    return {
        "eq18-second-order": lambda: _required_scale_error() * instruments.EXAMPLE_BIAS_ERROR / DEG_PER_SECOND < 1e-9,
        "eq20-words": _deviation_is_the_ratio,
        "example-angle": lambda: budget.whole_turns().angle / ARCSEC,
        "example-angle-unit": _unit_of_an_angle,
        "example-readout-unit": _unit_of_an_angle,
        "eq22-value": lambda: budget.ScaleFactorTest().deviation,
        "eq22-meets-scale": lambda: bool(budget.ScaleFactorTest().deviation < _required_scale_error()),
        "eq22-meets-asymmetry": lambda: budget.whole_turns().asymmetry_deviation < 2e-7,
        "angle-error": _angle_error,
        "mounting-limits": lambda: 10 * _angle_error() * ARCSEC < instruments.TABLE_POSITIONING,
    }


def _results() -> dict:
    return {
        "concl-bias": max(cell["spread"] for cell in instruments.TABLE_1.values()),
        "concl-method": _meets_all_requirements,
        "concl-angles-accuracy": lambda: bench.deviations_of_a_complete_calibration()["angle"] < 2 * ARCSEC,
        "concl-scale": lambda: max(simulation.relative_spreads().values()),
        "concl-angles": max(cell["spread"] for cell in instruments.TABLE_3.values()),
        "scale-not-reached": lambda: min(simulation.relative_spreads().values()) > _required_scale_error(),
    }


def _parameters() -> dict:
    return {
        "drift": instruments.GYRO_DRIFT / DEG_PER_HOUR,
        "rocking-angle": instruments.ROCKING_ANGLE / DEG,
        "rocking-period": instruments.ROCKING_PERIOD,
        "turn-rates": np.mean(instruments.TURN_RATES) / DEG_PER_SECOND,
        "stand-positioning": instruments.TABLE_POSITIONING / ARCSEC,
        "stand-stability": instruments.TABLE_RATE_STABILITY / PERCENT,
        "bias-duration": instruments.BIAS_DURATION / HOUR,
        "example-duration": instruments.EXAMPLE_DURATION,
        "example-readout": instruments.EXAMPLE_READOUT / ARCSEC,
        "example-noise": instruments.EXAMPLE_NOISE / ARCSEC,
        "example-bias": instruments.EXAMPLE_BIAS_ERROR / ARCSEC,
        "test-rates": np.mean(instruments.TEST_RATES) / DEG_PER_SECOND,
        "test-duration": instruments.TEST_DURATION / MINUTE,
        "test-temperature": instruments.TEST_TEMPERATURE_CHANGE,
    }


def _turn_drifts() -> bool:
    """Whether the errors in a simulated turn are constant and of the size that the requirements take them to have."""
    rate = instruments.TURN_RATES[0]
    errors = simulation.turning_errors(1e-6, ARCSEC, rate)
    sizes = [requirements.drift_from_scale_error(1e-6, rate), requirements.drift_from_misalignment(ARCSEC, rate)]
    return bool(np.allclose(errors, sizes, rtol=1e-9, atol=0))


def _required_scale_error() -> float:
    """Relative error of the scale factor for the slower turn, the larger of the two."""
    return float(requirements.scale_error_from_drift(instruments.GYRO_DRIFT, instruments.TURN_RATES[0]))


def _required_asymmetry() -> float:
    return float(requirements.asymmetry_from_drift(instruments.GYRO_DRIFT, instruments.MAX_RATE))


def _misalignment() -> float:
    """Misalignment that makes the accepted drift in the slower turn, where it may be larger, arcsec."""
    return float(requirements.misalignment_from_drift(instruments.GYRO_DRIFT, instruments.TURN_RATES[0])) / ARCSEC


def _meets_all_requirements() -> bool:
    """Whether one sigma of a complete calibration meets what the drift of 0.01 deg/h asks in a turn of 3 deg/s."""
    found = bench.deviations_of_a_complete_calibration()
    return (
        found["scale"] < _required_scale_error()
        and found["asymmetry"] < _required_asymmetry()
        and found["angle"] < _misalignment() * ARCSEC
    )


def _turned() -> float:
    """Angle of 36 turns, rad."""
    return 36 * REVOLUTION


def _readout_error(readout: float) -> float:
    """Relative error of a scale factor that a readout error makes over 36 turns."""
    return float(requirements.scale_error_from_readout(readout, _turned()))


def _one_digit(value: float) -> float:
    return float(f"{value:.0e}")


def _eq14_index() -> Proof:
    """Whether the printed and the corrected index give the two off-diagonal cosines of the column y."""
    needed = {"xy", "zy"}
    return Proof(printed={f"{i}y" for i in "yz"} == needed, corrected={f"{j}y" for j in "xz"} == needed)


def _eq17_source() -> Proof:
    """Whether the first approximation M', which is to be replaced, occurs in the equation that is named."""

    def has_first_approximation(name: str) -> bool:
        return any("M_1" in map(str, part.free_symbols) for part in derivation.equations()[name].printed)

    return Proof(printed=has_first_approximation("eq04"), corrected=has_first_approximation("eq14"))


def _eq20_denominator() -> Proof:
    """Whether the integral, and the integral times M, is the angle of whole turns: put into (19), which holds."""
    import sympy as sp

    M, integral, n = sp.symbols("M I n", positive=True)
    turned = 2 * sp.pi * n  # alpha(T) - alpha(0)
    solved = sp.solve(sp.Eq(M * integral, turned), integral)[0]
    return Proof(printed=sp.simplify(solved - turned) == 0, corrected=sp.simplify(M * solved - turned) == 0)


def _eq22_sqrt2() -> Proof:
    """The readout's part of (22) alone: against (21) and the derivation."""
    import sympy as sp

    equation = derivation.equations()["eq22"]
    a, n = sp.symbols("sigma_a n", positive=True)
    silent = dict.fromkeys(sp.symbols("sigma_g C_n", positive=True), 0)
    derived, printed = (sp.simplify(part[0].subs(silent)) for part in (equation.derived, equation.printed))
    with_root = sp.sqrt(2) * a / (2 * sp.pi * n)
    return Proof(printed=sp.simplify(derived - printed) == 0, corrected=sp.simplify(derived - with_root) == 0)


def _unit_of_an_angle() -> Proof:
    """Whether a rate, and an angle, may stand where (22) adds to bias error times time and divides by 2 pi n.

    By powers of the second: the bias error has -1 and the time 1, so their product has 0, as the other terms must.
    """
    arcsec_per_second, arcsec, needed = -1, 0, -1 + 1
    return Proof(printed=arcsec_per_second == needed, corrected=arcsec == needed)


def _rates_near_max() -> bool:
    """Whether the corrected (22) falls with the rate over the tested range, at equal duration."""
    rates = np.geomspace(*instruments.TEST_RATES, 20)
    return bool((np.diff([budget.at_rate(rate).deviation for rate in rates]) < 0).all())


def _second_enough() -> bool:
    """Whether the second approximation brings the scale factor error from above 1e-6 to below 1e-9."""
    first, second = simulation.second_approximation_error(instruments.MISALIGNMENT_LIMIT)
    return second < 1e-9 < 1e-6 < first


def _deviation_is_the_ratio() -> bool:
    """Whether simulated tests scatter by the combined readout and drift errors over the angle turned."""
    test, runs = budget.ScaleFactorTest(), 20_000
    errors = budget.simulate(test, runs, np.random.default_rng(20), steps=60)
    return bool(np.isclose(errors[0].std(), test.deviation, rtol=4 / np.sqrt(2 * runs)))


def _angle_error() -> float:
    """Error of an angle by the corrected (23) with the numbers of the example, arcsec."""
    test, cosine = budget.ScaleFactorTest(), np.sin(instruments.MISALIGNMENT_LIMIT)
    parts = test.parts
    readings = np.hypot(parts["bias"], parts["noise"]) / test.angle
    return float(np.hypot(readings, np.hypot(test.deviation, parts["readout"] / test.angle) * cosine)) / ARCSEC
