"""Beihang lecture slides on optical inertial units: laboratory calibration and temperature, formulas rebuilt, proofs.

`values` maps the rows of the ledger to what computes them.
"""

from collections.abc import Callable
from itertools import permutations
from typing import Any

import numpy as np

from fogkit.claims import Proof
from fogkit.constants import EARTH_RATE
from fogkit.earth import earth_rate_n, gravity_n
from fogkit.reproduction.beihang import derivation, effects, formulas, points, rates, redundancy, slides, temperature
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, MINUTE

__all__ = ["derivation", "effects", "formulas", "points", "rates", "redundancy", "slides", "temperature", "values"]

_BEST_RATE = slides.RATE_RANGE


def values() -> dict[str, Callable[[], Any] | Any]:
    """What computes each row of the ledger, by row id; see `fogkit.claims`."""
    rows = _overview() | _models() | _points() | _solution() | _advantages() | _cube() | _rate_list() | _temperature()
    return {f"beihang-{name}": value for name, value in rows.items()}


def _overview() -> dict:
    return {
        "output": _senses_rate,
        "kind-1": lambda: _model("accelerometer-triad", 12) and _model("gyro-triad", 12),
        "kind-2-gyros": lambda: _not_redundant(13, range(1, 4)),
        "kind-2-accelerometers": lambda: _not_redundant(12, range(1, 3)),
        "kind-3": lambda: all(
            axes.rows > 3 for name, axes in redundancy.configurations().items() if name != "orthogonal"
        ),
        "redundant-accuracy": lambda: all(
            max(redundancy.variances(name)) < 1 for name in ("skew", "cone", "dodecahedron")
        ),
        "redundant-reliability": lambda: all(
            redundancy.survives(name, failed) for name, failed in (("skew", 1), ("cone", 1), ("dodecahedron", 3))
        ),
        "four-skew": lambda: _variance("skew") == 5 / 6,
        "four-symmetric": lambda: _variance("cone") == 3 / 4,
        "six-symmetric": lambda: _variance("dodecahedron") == 1 / 2,
        "supply": slides.SUPPLY,
        **{name: (lambda name=name: _standard(name)) for name in slides.STANDARDS},
        "redundant-life": lambda: all(
            redundancy.mean_life(name) > redundancy.mean_life("orthogonal") for name in ("skew", "cone", "dodecahedron")
        ),
        "deterministic": derivation.level_estimates_are_exact,
        "earth-rate": EARTH_RATE / DEG_PER_HOUR,
        "reference-rates": lambda: bool(np.isclose(np.linalg.norm(earth_rate_n(slides.ASSUMED_LATITUDE)), EARTH_RATE)),
        "screening-word": lambda: Proof(printed="是" in slides.SCREENING[0], corrected="是" in slides.SCREENING[1]),
        "ref-horizontal": lambda: np.abs(gravity_n(np.linspace(-90, 90, 181) * DEG)[:, :2]).max(),
    }


def _models() -> dict:
    no_plane = ("UEN", "NUE", "ENU", "ESD")  # x, y, z up, z down
    return {
        "four-position": lambda: derivation.rank_of(no_plane) == 4 and derivation.rank_of(_about_horizontal()) == 3,
        "multiposition": lambda: derivation.rank_of(tuple(points.attitudes().values())) == 4,
        "rate-every-axis": lambda: derivation.rank_of_rates((0, 1, 2)) == 3 > derivation.rank_of_rates((0, 1)),
        "gyro-model": lambda: _model("gyro", 2),
        "gyro-triad": lambda: _model("gyro-triad", 12),
        "accelerometer-model": lambda: _model("accelerometer-axis", 4),
        "accelerometer-triad": lambda: _model("accelerometer-triad", 12),
        "coefficients": formulas.coefficients_of_both_triads,
        "coefficients-list": lambda: formulas.coefficients_of_both_triads() == slides.COEFFICIENTS,
    }


def _points() -> dict:
    printed = slides.ATTITUDES
    return {
        "positions": lambda: len(points.positions()),
        "points": len(slides.POINTS_OF_THE_CIRCLE),
        "points-total": lambda: len(set(points.attitudes().values()) & _right_handed_attitudes()),
        "circle": lambda: all(
            points.quarter_turns(labels) for labels in (*points.positions().values(), *_printed_positions())
        ),
        **{
            f"point-{name}": (lambda name=name: points.attitudes()[name] == printed[name] and _right(printed[name]))
            for name in printed
        },
        "points-right-handed": lambda: all(map(_right, printed.values())),
        "points-others": lambda: all(map(_right, points.attitudes().values())),
        "mean": derivation.horizontal_cancels,
        "raw-size": lambda: (len(points.attitudes()), _sensors()) == slides.RAW_SHAPE,
        "mean-size": lambda: (len(points.positions()), _sensors()) == slides.MEAN_SHAPE,
    }


def _solution() -> dict:
    regression = derivation.regression_is_closed_forms
    return {
        "acc-model": lambda: _model("accelerometer-axis", 4) and formulas.formulas()["accelerometer-axis"].is_linear,
        "acc-model-cosines": _components_are_equivalent_times_cosines,
        "acc-equations": lambda: derivation.design().rows,
        "acc-unknowns": lambda: derivation.design().rank() == slides.UNKNOWNS == derivation.design().cols,
        "acc-regression": lambda: derivation.design().rows > derivation.design().rank() == derivation.design().cols,
        "acc-regression-result": derivation.level_estimates_are_exact,
        "acc-zero": lambda: (
            regression() and derivation.zero_term_variances()[1] == 3 * derivation.zero_term_variances()[0]
        ),
        "acc-components-result": regression,
        "acc-equivalent": _components_are_equivalent_times_cosines,
        "acc-cosines": _components_are_equivalent_times_cosines,
        "gyro-axis": lambda: _model("gyro-axis", 8),
        "gyro-turns": slides.TURN / DEG,
        "gyro-turns-size": lambda: len(points.positions()) == 3 * 2,
        "gyro-turns-component": _turns_give_components,
        "gyro-pulses": 2 * slides.TURN / ARCSEC == 2 * 360 * 3600,
        "gyro-zero-negligible": _equal_turns_cancel,
        "gyro-array-index": lambda: Proof(
            printed="I" in slides.DEFINED_INDICES.values(), corrected=slides.DEFINED_INDICES["gyro"] == "i"
        ),
        "gyro-equations": lambda: derivation.design().rows,
        "gyro-unknowns": lambda: _model("gyro-axis-static", slides.UNKNOWNS),
        "gyro-regression": lambda: derivation.design().rank() == 4,
        "gyro-turns-first": lambda: derivation.static_rank(True) == 4 == derivation.static_rank(False),
        "gyro-regression-set": derivation.level_estimates_are_exact,
        "gyro-regression-result": derivation.level_estimates_are_exact,
        "gyro-closed": regression,
    }


def _advantages() -> dict:
    def exact(name):
        return lambda: derivation.mislevelling_order()[name] is None

    def first(name):
        return derivation.mislevelling_order()[name] == 1

    level = derivation.level_estimates_are_exact  # Earth rate and gravity of any azimuth are in it
    return {
        "adv-azimuth": derivation.horizontal_cancels,
        "adv-horizontal-zero": lambda: derivation.horizontal_cancels() and level(),
        "adv-horizontal-g": lambda: derivation.horizontal_cancels() and level(),
        "adv-horizontal-turns": _turns_give_components,
        "adv-level-rate": lambda: _order_of_tilt("rate") > 1,
        "adv-level-rate-zero": exact("gyro zero term"),
        "adv-level-rate-g": lambda: not first("gyro g-dependent terms"),
        "adv-level-rate-turns": lambda: exact("gyro equivalent")() and exact("gyro cosines")(),
        "adv-level-gravity-zero": exact("accelerometer zero term"),
        "adv-level-gravity": lambda: derivation.mislevelling_order()["accelerometer equivalent"] == 2,
        "adv-level-gravity-cosines": exact("accelerometer cosines"),
        "adv-level-horizontal": derivation.horizontal_cancels,
        "adv-plumb": lambda: effects.opposite_faces_disturb_zero_term() == 0,
        "weak-scale": lambda: bool(_list_against_turns(_BEST_RATE) > 10),
    }


def _cube() -> dict:
    signs = effects.angles_towards_third_axis
    east = effects.east_bias_error
    return {
        "cube-acc-model": lambda: _model("accelerometer-triad", 12),
        "cube-acc-angles": lambda: sorted(signs().values()) == [-1] * 3 + [1] * 3,
        "cube-north": derivation.horizontal_cancels,
        "cube-positions": lambda: len(points.positions()),
        "cube-duration": slides.ACCELEROMETER_DURATION / MINUTE,
        "cube-acc-bias": derivation.regression_is_closed_forms,
        "cube-acc-scale-result": derivation.regression_is_closed_forms,
        "cube-acc-angles-result": derivation.level_estimates_are_exact,
        "cube-gyro-model": lambda: _model("gyro-triad", 12),
        "east-positions": slides.BIAS_POSITIONS,
        "east-duration": slides.BIAS_DURATION / MINUTE,
        "east-mean": lambda: east()["nominal"] == 0 and effects.east_pair_cancels(),
        "east-formula": lambda: east()["nominal"] == 0,
    }


def _rate_list() -> dict:
    magnitudes = rates.magnitudes() / DEG_PER_SECOND
    return {
        "rate-range": slides.RATE_RANGE / DEG_PER_SECOND,
        "rate-within": bool(np.abs(slides.RATES).max() <= slides.RATE_RANGE),
        "rate-order": _listed_by_pairs,
        **{f"rate-{magnitude:.3g}": magnitude for magnitude in magnitudes},
        "rate-duration": slides.RATE_DURATION / MINUTE,
        "rate-installation": slides.INSTALLATION_RATE / DEG_PER_SECOND,
        "rate-bias": lambda: effects.east_bias_error()["nominal"] == 0,
        "rate-yz": _turns_give_components,
    }


def _temperature() -> dict:
    def coefficients(name, count):
        return lambda: _model(name, count) and formulas.formulas()[name].is_linear

    return {
        **{f"temp-{name}": statement for name, statement in temperature.STATEMENTS.items()},
        "temp-bias": coefficients("bias-temperature", 3),
        "temp-regression": lambda: all(
            formulas.formulas()[name].is_linear for name in ("bias-temperature", "start-up-long", "steady-state")
        ),
        "temp-points": slides.LEAST_TEMPERATURE_POINTS,
        "temp-model": coefficients("steady-state", 7),
        "temp-short-model": coefficients("start-up-short", 2),
        "temp-long-points": slides.START_UP_POINTS,
        "temp-long-variables": lambda: formulas.temperature_variables(slides.START_UP_POINTS) == 4,
        "temp-long-model": coefficients("start-up-long", 5),
        "temp-steady-latter": _words_point_where_they_should,
        "temp-steady-word": lambda: Proof(
            # kept, points that matter little would add to the six variables
            printed=formulas.temperature_variables(slides.STEADY_POINTS) > slides.STEADY_VARIABLES,
            corrected=formulas.temperature_variables(slides.STEADY_POINTS) == slides.STEADY_VARIABLES,
        ),
        "temp-steady-variables": lambda: formulas.temperature_variables(slides.STEADY_POINTS),
        "temp-steady-model": coefficients("steady-state", 7),
        "temp-acc-bias": lambda: coefficients("accelerometer-bias", 4)() and _degree("accelerometer-bias") == 3,
        "temp-acc-scale": lambda: coefficients("scale-factor", 2)() and _degree("scale-factor") == 1,
    }


def _senses_rate() -> Proof:
    """Whether the delay of light in a ring is zero at a constant rate, as for angular acceleration."""
    delay = effects.sagnac_delay()
    (rate,) = (symbol for symbol in delay.free_symbols if symbol.name == "omega")
    return Proof(printed=delay == 0, corrected=delay.subs(rate, 0) == 0 and delay.diff(rate).subs(rate, 0) != 0)


def _not_redundant(printed: int, meant: range) -> Proof:
    """Whether a number of sensors, and all of a range, are below the more than three of the redundant kind."""
    return Proof(printed=printed <= 3, corrected=max(meant) <= 3)


def _variance(name: str) -> float:
    (variance,) = set(redundancy.variances(name))
    return float(variance)


def _standard(name: str) -> Proof:
    """Whether number and title, and their correction, are those of the catalogue."""
    printed, catalogued = zip(*slides.STANDARDS[name], strict=True)
    corrected = {  # as the ledger has it
        "ieee-952": (printed[0], printed[1].replace("Interferomentric", "Interferometric")),
        "gjb-2426": (printed[0].replace("2426", "2426A"), printed[1].replace("光纤陀螺", "光纤陀螺仪")),
        "gjb-1037": (printed[0], printed[1].replace("实验", "试验")),
    }[name]
    return Proof(printed=printed == catalogued, corrected=corrected == catalogued)


def _model(name: str, coefficients: int) -> bool:
    """Whether a rebuilt model has as many coefficients as the words name, and all its terms."""
    formula = formulas.formulas()[name]
    return len(formula.coefficients) == coefficients and formula.has_all_terms()


def _degree(name: str) -> int:
    return formulas.formulas()[name].degree("T")


def _sensors() -> int:
    return len(formulas.AXES) * len(("accelerometer", "gyro"))


def _right(label: str) -> bool:
    return bool(points.is_right_handed(label))


def _right_handed_attitudes() -> set[str]:
    """All right-handed attitudes along east, north and up, found by trying every three letters."""
    directions = ("EW", "NS", "UD")
    labels = {
        first + second + third for a, b, c in permutations(directions) for first in a for second in b for third in c
    }
    return {label for label in labels if _right(label)}


def _printed_positions() -> list[tuple[str, ...]]:
    labels = tuple(slides.ATTITUDES.values())
    return [labels[: slides.POINTS], labels[slides.POINTS :]]


def _about_horizontal() -> tuple[str, ...]:
    """x stays to the east while y goes from north to up, south and down."""
    return ("ENU", "EUS", "ESD", "EDN")


def _components_are_equivalent_times_cosines() -> bool:
    import sympy as sp

    components = sp.Matrix(sp.symbols("K_x K_y K_z", positive=True))
    length, cosines = derivation.equivalent_and_cosines(components)
    return (length * cosines - components).is_zero_matrix and sp.simplify(cosines.dot(cosines)) == 1


def _turns_give_components() -> bool:
    """Whether turns of equal duration give the three components exactly, on a plate with any tilt and azimuth."""
    import sympy as sp

    found, true = derivation.estimates()["turns"]
    return (found - true).applyfunc(sp.simplify).is_zero_matrix


def _equal_turns_cancel() -> bool:
    """Whether what unequal durations leave is in proportion to their difference."""
    import sympy as sp

    return sp.simplify(derivation.turns_error() - derivation.expected_turns_error()) == 0


def _order_of_tilt(name: str) -> int:
    """Lowest order of the tilt in gravity, "force", or Earth rate, "rate", along the normal of the plate."""
    import sympy as sp

    tilt = derivation.tilt_symbols()[3]
    along = derivation.along_normal()[name]
    return next(n for n in (1, 2) if sp.simplify(along.diff(tilt, n).subs(tilt, 0)) != 0)


def _list_against_turns(rate: float) -> float:
    """How many times the scale factor is more precise by the list of rates than by one turn each way at a rate."""
    noise = slides.ASSUMED_ANGLE_RANDOM_WALK
    return rates.scale_deviation_of_turns(noise, rate) / rates.scale_deviation_of_list(noise)


def _listed_by_pairs() -> bool:
    """Whether the list is rest, then pairs of one rate in the positive and the negative sense, ascending."""
    pairs = slides.RATES[1:].reshape(-1, 2)
    return bool(
        slides.RATES[0] == 0
        and (pairs[:, 0] == -pairs[:, 1]).all()
        and (np.diff(pairs[:, 0]) > 0).all()
        and pairs[0, 0] > 0
    )


def _words_point_where_they_should() -> bool:
    """Whether start-up is said to be heated from within and the steady state to be disturbed by the ambient."""
    meant = {slides.ORDER_OF_SENTENCE[word]: source for word, source in slides.DRIFT_SOURCES.items()}
    return meant == {"start-up": "within", "steady state": "ambient"}
