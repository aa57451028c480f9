"""B. V. Klimkovich (2022), calibration of a strapdown system on a rough turntable: inputs, plan, proofs, experiments.

`values` maps the rows of the ledger to what computes them. The paper's figure 1, which shows where the nine tests start
and how they turn, is lost; `plan_search` recovers it from the matrix of the appendix, by the first-order model of
`fogkit.calibration.navigation_based.turn_model`.

===================  =====================================================================================
module               answers
===================  =====================================================================================
`paper`              what does the paper state in numbers?
`plan_search`        what did the lost figure 1 show, and what is misprinted in the appendix?
`derivation`         which equations follow, with which signs?
`ideas`              does the idea of the method hold in the model of a turn?
`regression`         what do straight lines and their residuals tell, (21)-(24)?
`conditioning`       how well is the plan conditioned, how many turns does it need, (28)?
`estimates`          what do gyro bias and start attitude really do, (32)-(35)?
`tables`             what can be said of tables 1 and 2?
`trials`             which unit, on which table, is calibrated in the experiments?
`convergence`        how does the iteration converge, with which matrix (figures 2 to 5)?
`bias_sources`       what do size effect, delays, gyro biases and the start do to the result?
`gyro_bias_test`     what do (29)-(31) find (figure 6)?
`gyro_delays`        what do delays of gyros that differ do in a turn?
`remedies`           what helps against each source, before and after?
`bias_accuracy`      how sure are gyro biases and azimuths, and what does table 2 say of the gyros?
`verdicts`           do the claims in words hold in the experiments?
`matrix_comparison`  what does each step of the iteration leave, with which matrix, on which table?
`campaigns`          do stated standard deviations hold over many simulated calibrations?
`confidence`         what can chi-square see, what hangs together in table 1, and if the noise is another?
===================  =====================================================================================
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fogkit.calibration.navigation_based import turns_needed
from fogkit.calibration.navigation_based.turn_model import MISALIGNED_WITH, PARAMETERS
from fogkit.claims import Proof
from fogkit.reproduction.klimkovich import (
    bias_sources,
    conditioning,
    confidence,
    convergence,
    derivation,
    estimates,
    gyro_bias_test,
    ideas,
    paper,
    plan_search,
    regression,
    tables,
    trials,
    verdicts,
)
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import ARCSEC, CENTIMETRE, DEG, MINUTE

__all__ = [
    "bias_sources",
    "conditioning",
    "convergence",
    "derivation",
    "estimates",
    "gyro_bias_test",
    "ideas",
    "paper",
    "plan_search",
    "regression",
    "tables",
    "trials",
    "values",
    "verdicts",
]


def values() -> dict[str, Callable[[], Any] | Any]:
    """What computes each row of the ledger, by row id; see `fogkit.claims`."""
    rows = _introduction() | _equations() | _statistics() | _plan() | _appendix() | _table_1() | _table_2() | _errors()
    rows |= _experiments()
    return {f"klimkovich-{name}": value for name, value in rows.items()}


def _introduction() -> dict:
    return {
        "intro-size-one": lambda: ideas.unknowns_of_size_effect(1),
        "intro-size-two": lambda: ideas.unknowns_of_size_effect(2),
        "intro-size-distance": paper.SENSITIVITY_CENTRES[1] / CENTIMETRE,
        "intro-idea-rest": lambda: ideas.stays_where_it_is() < 1e-6,
        "intro-idea-turn": ideas.perfect_unit_stays_level,
        "intro-idea-errors": ideas.every_error_shows,
        "intro-idea-start": ideas.start_does_not_matter,
        "intro-schuler": lambda: ideas.turn_of_a_dwell() < 0.02,  # its square bends the line by 1e-4 of the slope
        "gauge": ideas.gauge_removes_the_frame,
        "subtract": lambda: ideas.error_after_one_step() < 1e-3 < 1 < ideas.error_after_one_step(-1),
        "level-axis": _level_axis_is_best,
    }


def _level_axis_is_best() -> bool:
    """Whether the sight of a gyro's scale factor falls steadily to nothing as the axis of the turn rises to upright."""
    sight = [conditioning.sight_of_scale_factor(elevation) for elevation in np.linspace(0, np.pi / 2, 19)]
    return bool((np.diff(sight) < 0).all() and sight[-1] < 1e-9)


def _equations() -> dict:
    proofs = ("eq03", "eq04", "eq09", "eq10", "eq26", "eq29", "eq30", "eq31")
    return {
        **{name: (lambda name=name: derivation.proof(name)) for name in proofs},
        "eq11": lambda: derivation.proof("eq11").printed and ideas.order_of_eq12(0) > 0.9,
        **{f"eq{number}": (lambda number=number: _row_equation(f"eq{number}")) for number in range(14, 20)},
        "eq13": len(PARAMETERS) == 15,
        "permutation": tuple(axis + 1 for axis in MISALIGNED_WITH) == (3, 1, 2),
        "eq26-tests": lambda: plan_search.upended_axes(plan_search.recovered_plan()) == paper.SCALE_FACTOR_TESTS,
        "eq32": lambda: estimates.bias_proof("eq32"),
        "eq33": lambda: estimates.bias_proof("eq33"),
        "eq35": estimates.eq35_proof,
    }


def _row_equation(name: str) -> bool:
    """Whether one of (14)-(19) follows by symbols, and all of them are the derivatives of exact slopes."""
    return derivation.proof(name).printed and ideas.rows_are_derivatives()


def _statistics() -> dict:
    return {
        "eq20-r": lambda: all(map(regression.residuals_tell_the_slope, regression.KINDS)),
        "eq21-range": regression.eq21_range,
        "eq22": regression.eq22_shapes,
        "eq22-diagonal": ideas.east_and_north_are_independent,
        "eq22-independent": lambda: all(
            regression.noise_in_slopes(kind).residual_correlation < 1e-9 for kind in regression.KINDS
        ),
        "eq23": lambda: regression.residuals_tell_the_slope("white velocity"),
        "eq24": regression.eq24_holds,
        "eq24-s": lambda: all(regression.residual_freedom(count) == count - 2 for count in (3, 4, 7)),
        "eq27-size": len(PARAMETERS),
        "eq28": _eq28,
    }


def _eq28() -> Proof:
    """Whether (28), and its correction, give back the whole turns of plans whose covariance is computed."""
    deviations = {turns: conditioning.scale_factor_deviation(turns) for turns in range(1, 9)}

    def holds(printed: bool, tolerance: float) -> bool:
        needed = [turns_needed(1.0, deviation, gravity=1.0, printed=printed) for deviation in deviations.values()]
        return bool(np.allclose(needed, list(deviations), rtol=0, atol=tolerance))

    return Proof(printed=holds(True, 0.5), corrected=holds(False, 1e-9))


def _plan() -> dict:
    return {
        "tests": lambda: len(nine_tests()),
        "plan-angles": lambda: (
            [90 * turn.quarters - 360 * paper.TURNS for turn in plan_search.recovered_plan()] == [90, 180, 90] * 3
        ),
        "plan-level": lambda: all(turn.along in "EWNS" for test in plan_search.search() for turn in test.turns),
        "plan-condition": lambda: not any(conditioning.ranks_of_the_printed_plan().values()),
        "plan-n": lambda: round(plan_search.recovered_plan()[0].angle / (2 * np.pi) - 0.25),
        "start-identity": lambda: np.array_equal(plan_search.recovered_plan()[0].C_b_n, np.eye(3)),
    }


def _appendix() -> dict:
    return {
        "app-size": lambda: plan_search.measurement_matrix().shape == (18, 15),
        "app-zeros": _unprinted_zeros,
        "app-blocks": lambda: (
            {
                axis: ["xyz"[plan_search.recovered_plan()[test - 1].axis] for test in tests]
                for axis, tests in paper.BLOCKS.items()
            }
            == {axis: [axis] * 3 for axis in "xyz"}
        ),
        **{f"h-{entry.row:02d}-{entry.column:02d}": (lambda entry=entry: _element(entry)) for entry in paper.MATRIX},
    }


def _element(entry: paper.Entry) -> float | Proof:
    """What stands in a printed place, in the printed unit; for a misplaced element whether either place is right."""
    H = plan_search.measurement_matrix()
    moved = {m.printed: m.correct for m in plan_search.misprints() if m.correct.column != m.printed.column}
    if entry in moved:
        places = (entry, moved[entry])
        return Proof(
            **{
                name: bool(np.isclose(H[place.row, place.column], place.value()))
                for name, place in zip(("printed", "corrected"), places, strict=True)
            }
        )
    return H[entry.row, entry.column] / (np.pi if entry.of_pi else 1)


def _unprinted_zeros() -> Proof:
    """Whether all places without a print are zero, and all but the two to which misplaced elements belong."""
    H = plan_search.measurement_matrix()
    unprinted = paper.printed_matrix() == 0
    where = {(int(i), int(j)) for i, j in np.argwhere(unprinted & (np.abs(H) > 1e-9))}
    return Proof(printed=not where, corrected=where == {(7, 0), (17, 8)})


def _table_1() -> dict:
    return {
        **{f"table1-{name.replace('_', '')}": (lambda name=name: tables.fitted(name)) for name in PARAMETERS},
        "table1-pattern": _pattern_of_table_1,
        "table1-formula": _formula_of_table_1,
        "table1-consistent": _table_1_is_consistent,
        "table1-heading": Proof(printed="m_a_12" in PARAMETERS, corrected="m_a_13" in PARAMETERS),
        "table1-footnote": lambda: any(
            f"m^a_{axis}{axis}" in {str(symbol) for symbol in derivation.half_difference(axis).free_symbols}
            for axis in (1, 2, 3)
        ),
    }


def _table_1_is_consistent() -> bool:
    """Whether the scale factor cells are within what the rounding of three others allows, with any diagonal R."""
    cells = confidence.scale_factors_of_table_1()
    return bool(cells["printed"].between(cells["low"], cells["high"]).all())


def _formula_of_table_1() -> Proof:
    """Whether (21) has the unit of an angle, and whether (27) makes the cells that follow from the plan.

    By powers of the metre and of the second: a residual of a velocity against an angle.
    """
    velocity, angle = (1, -1), (0, 0)
    return Proof(printed=velocity == angle, corrected=tables.four_levels().largest < 0.01)


def _pattern_of_table_1() -> bool:
    """Whether the plan treats the groups of the table alike, as the table does, and puts its angles in that order."""
    alike = tables.group_spread(as_printed=False) < 1 + 1e-9 < tables.printed_group_spread() < 1.02
    return bool(alike and tables.gyro_angle_ratio() > 2)


def _table_2() -> dict:
    return {
        "table2-contents": any("bias" in column for column in paper.TABLE_2_COLUMNS),
        "table2-deviation": lambda: tables.table_2_statistics()["rms"],
        "bias-dwell": paper.BIAS_TEST_DWELL / MINUTE,
        "table2-time": paper.GYROCOMPASSING_TIME / MINUTE,
    }


def _errors() -> dict:
    """The paper's estimate of its errors."""
    return {
        "eq33-t": paper.TEST_DURATION,
        "eq33-bias": paper.GYRO_BIAS_LEFT,
        "eq33-value": lambda: estimates.angle_of_bias() / ARCSEC,
        "eq34": _eq34,
        "schuler": lambda: float(estimates.schuler_frequencies(estimates.LATITUDE).mean()),
        "eq35-start": paper.START_ANGLE / DEG,
        "eq35-value": lambda: estimates.angle_of_start() / ARCSEC,
        "model-start": lambda: max(row["both"] for row in estimates.start_effects().values()) < _conceded(),
        "second-degree": _second_degree_shows_bias,
    }


def _experiments() -> dict:
    """Claims in words that take recordings."""
    return {
        "abs-residual": verdicts.actual_matrix_is_more_accurate,
        "abs-iterations": verdicts.actual_matrix_is_faster,
        "abs-rough": verdicts.calibrates_to_table_1,
        "intro-conditioning": ideas.more_states_are_worse,
        "intro-model-bias": verdicts.model_matrix_may_leave_errors,
        "differences-delays": verdicts.delays_do_not_enter,
        "differences-size": verdicts.size_effect_does_not_enter,
        "angles-actual": verdicts.computed_turns_become_true,
        "model-systematic": verdicts.model_matrix_is_biased,
        "table-errors": verdicts.table_shows_in_a_rotation_only,
        "fig2-slopes": verdicts.slopes_differ_at_first,
        "fig3-slopes": verdicts.slopes_agree_at_last,
        "fig3-oscillations": verdicts.oscillations_are_size_effect_and_delays,
        "fig4-faster": verdicts.actual_matrix_is_faster,
        "fig4-floor": verdicts.actual_matrix_has_the_lower_floor,
        "fig5-flat": verdicts.corrections_flat_from,
        "fig5-arithmetic": verdicts.corrections_end_in_rounding,
        "fig5-floor-n": verdicts.first_iteration_without_fall,
        "bias-heading": verdicts.heading_drops_out_of_the_biases,
        "start-from-dwell": verdicts.levelling_removes_the_tilt,
        "concl-delays": lambda: verdicts.delays_do_not_enter() and verdicts.size_effect_does_not_enter(),
        "concl-actual": verdicts.computed_turns_become_true,
        "concl-table": verdicts.table_shows_in_a_rotation_only,
        "concl-algorithm": verdicts.algorithm_adds_a_small_error,
        "concl-works": verdicts.calibration_works,
    }


def _conceded() -> float:
    """The error that (35) concedes a model attitude at the start, arcsec."""
    return estimates.angle_of_start() / ARCSEC


def _eq34() -> bool:
    """Whether Schuler's oscillation makes the larger part of what a tilt at the start changes in a test of 35 s."""
    effects = estimates.start_effects()
    return all(effects[axis]["schuler"] > effects[axis]["earth"] for axis in ("east", "north"))


def _second_degree_shows_bias() -> bool:
    """Whether a parabola leaves less of a gyro bias in the change of slope, so that the difference of both shows it."""
    change = estimates.degrees_compared()
    return change[2] < 0.7 * change[1]
