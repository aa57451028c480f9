"""Le Van Chang (2015), gyrocompass on a rocked mount: inputs, equations, requirements, simulation, experiments.

`values` maps the rows of the ledger to what computes them. The text is a scan with garbled formulas: `derivation` has
them as restored, beside what follows by derivation.

=====================  =====================================================================================
module                 answers
=====================  =====================================================================================
`paper`                what does the thesis state in numbers?
`pyramid`              which Euler sequence do the pyramid's printed angles belong to?
`derivation`           which equations follow, with which signs?
`differences`          do the equations agree with differences of the full nonlinear model?
`turns`                do (3)-(7) and the error model agree with turns and differences?
`kinematics`           what does integrating (6) and (7) cost near a vertical bow?
`verdicts`             do the claims in words on compasses, frames and equations hold?
`law_claims`           do the claims in words on the law of the mount hold?
`law_study`            what do laws do for heading: mean direction, observability, coloured noise, encoder?
`law_map`              how does heading accuracy go with amplitude and period, for aids of any accuracy?
`rates`                what do the rates of hull and mount leave of a gyro's range?
`requirements`         from a gyro's error to heading, with the mount off, (17)?
`requirement_claims`   do the claims in words on (17), tables 2 and 3 hold?
`sensors`              what do the gyros of table 3 give with the mount off and on, and what would do?
`design_runs`          does the filter reach what a design promises?
`simulation`           what do the motions of the simulation let be known, by covariance?
`simulation_runs`      which errors do filters and smoother make over 100 seeds?
`simulation_claims`    do the claims in words on the simulation hold?
`filtering`            what do the filters find over many seeds, and which may be believed?
`latitudes`            is the filter consistent from the equator to near a pole, at rest and under way?
`manoeuvres`           what does a turn of the vessel do, against rocking?
`course`               may the filter take the velocity to turn with the hull?
`scanning`             what can the static scan say, and does drift explain table 6?
`experiments`          how often does the second experiment meet 30 arcmin?
`experiment_verdicts`  do the claims of chapter 4 hold?
=====================  =====================================================================================
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fogkit.claims import Proof
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude, mean_direction
from fogkit.gyrocompass.error_model import MEASUREMENTS, STATES
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.reproduction.lechang import (
    derivation,
    experiment_verdicts,
    filtering,
    law_claims,
    law_study,
    paper,
    pyramid,
    rates,
    requirement_claims,
    requirements,
    simulation,
    simulation_claims,
    turns,
    verdicts,
)
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND, DEG_PER_SQRT_HOUR, MINUTE, PERCENT

__all__ = [
    "derivation",
    "experiment_verdicts",
    "filtering",
    "law_claims",
    "law_study",
    "paper",
    "pyramid",
    "rates",
    "requirement_claims",
    "requirements",
    "simulation",
    "simulation_claims",
    "turns",
    "values",
    "verdicts",
]


def values() -> dict[str, Callable[[], Any] | Any]:
    """What computes each row of the ledger, by row id; see `fogkit.claims`."""
    rows = _compasses() | _frames() | _equations() | _law() | _requirements() | _simulation() | _experiments()
    return {f"lechang-{name}": value for name, value in rows.items()}


def _compasses() -> dict:
    """Introduction and chapter 1."""
    return {
        "intro-modulation": verdicts.turning_replaces_better_gyros,
        "claim-3": verdicts.aiding_bounds_errors,
        "ch1-pendulum": verdicts.pendulum_seeks_the_meridian,
        "eq01": verdicts.level_gyro_reads_eq01,
        "eq02": verdicts.eq02_inverts_eq01,
        "ch1-ins": verdicts.at_rest_nothing_changes,
        "ch1-growth": verdicts.aiding_bounds_errors,
        "ch1-observability": verdicts.fixed_unit_hides_heading,
        "ch1-remedy": verdicts.turning_shows_all,
        "ch1-lasers": verdicts.each_gyro_is_turned,
        "ch1-pyramid-compensates": verdicts.turning_compensates_across_the_axis,
        "ch1-omega": verdicts.cube_shows_azimuth_gyro_only,
        "table1-2-km11": verdicts.turning_shows_all,
        "table1-2-pl41": verdicts.turning_shows_all,
        "table1-2-omega": verdicts.cube_hides_an_error,
    }


def _frames() -> dict:
    return {
        **dict.fromkeys(("frame-geographic", "frame-hull", "frame-sequence"), verdicts.frames_are_as_stated),
        "frame-accelerometers": verdicts.accelerometers_do_not_turn,
        "frame-pyramid": verdicts.each_gyro_is_turned,
        "frame-beta": verdicts.sense_of_the_mount,
        "frame-euler": lambda: len(pyramid.sequences().query("upward and equation_13")) == 1,
        "frame-psi": lambda: verdicts.euler_angles()[0],
        "frame-theta": lambda: verdicts.euler_angles()[1],
        "frame-gamma": lambda: verdicts.euler_angles()[2],
        "frame-orthogonal": lambda: abs(verdicts.inclination_that_is_orthogonal() - paper.PYRAMID_ANGLES_DEG[1]) < 0.05,
        "law-axis": verdicts.mount_stands_on_the_normal,
    }


def _equations() -> dict:
    columns = ("heading", "trim", "roll", "velocity-north", "velocity-east", "lat", "alt", "gyro-x", "gyro-y", "gyro-z")
    return {
        **{name: (lambda name=name: turns.follows(name)) for name in ("eq03", "eq04", "eq05")},
        **{
            f"eq06-{angle}": (lambda angle=angle: derivation.holds(f"eq06-{angle}") and turns.follows("eq06"))
            for angle in ("heading", "trim", "roll")
        },
        "eq06-singular": lambda: turns.rates_near_a_vertical_bow(paper.LARGEST_TILT) < 1.02,
        "eq07": lambda: turns.angles_by_integration() < 1e-7,
        **{f"eq08-{name}": (lambda name=name: verdicts.restored(f"eq08-{name}")) for name in columns},
        "eq08-errors": turns.errors_of_a_gyro_act_alike,
        **dict.fromkeys(("eq08-others", "eq09"), lambda: turns.error_model_departure() < turns.TOLERANCE),
        "eq10": len(STATES),
        "eq10-noise": turns.errors_of_a_gyro_act_alike,
        "eq11": len(MEASUREMENTS),
        "eq12": turns.measurement_takes_its_states,
        **{name: (lambda: derivation.holds("eq13")) for name in ("eq13", "eq13-k1", "eq13-k2")},
        **{
            f"eq14-{term}": (lambda term=term: derivation.holds(f"eq14-{term}"))
            for term in ("heading", "angle", "rate")
        },
        **{
            f"eq17-{name}": (lambda name=name: verdicts.restored_17(name))
            for name in ("gyro-x", "gyro-y", "gyro-z", "roll", "trim")
        },
        "eq17-51": lambda: float(np.rad2deg(np.arctan(np.sqrt(1.5)))),
        "eq17-39": lambda: float(np.rad2deg(np.arctan(np.sqrt(2 / 3)))),
    }


def _law() -> dict:
    """The choice of the law, end of chapter 2."""
    heading, trim, roll = (rate / DEG_PER_SECOND for rate in rates.hull_rates())
    return {
        "novelty-2": law_claims.quasi_harmonic_is_best,
        "law-range": law_claims.range_limits_the_law,
        "law-observable": lambda: verdicts.turning_shows_all() and not verdicts.fixed_unit_shows_all(),
        "eq14-left-out": law_claims.tilt_enters_by_tan_lat,
        "law-two-positions": law_claims.two_positions,
        "law-amplitude": _amplitude,
        "law-half-turn": verdicts.half_turn_changes_the_sign,
        "law-half-turn-seen": law_claims.half_turn_shows_the_bias,
        "law-encoder": law_claims.harmonic_keeps_encoder_errors_out,
        "law-encoder-smooth": _gentle_ends,
        "law-unsteady": law_claims.unsteady_speed_speaks_against_constant_speed,
        "rate-heading": heading,
        "rate-trim": trim,
        "rate-roll": roll,
        "gyro-range": paper.GYRO_RANGE / DEG_PER_SECOND,
        "scale-limit": paper.SCALE_FACTOR_LIMIT / PERCENT,
        "rate-limit": paper.GYRO_RANGE / 2 / DEG_PER_SECOND,
        "rate-left": lambda: rates.budgets()["squares"].mount_rate / DEG_PER_SECOND,
        "rate-left-rad": lambda: rates.budgets()["squares"].mount_rate,
        "rate-limit-enough": law_claims.scale_factor_is_met_at_half_range,
        "rate-sum": law_claims.rates_add_as_squares,
        "eq16": law_claims.rate_follows_from_the_law,
        "period": lambda: rates.budgets()["squares"].period,
        "period-180": lambda: rates.budgets(paper.MOUNT_AMPLITUDE)["squares"].period,
        "conclusion-3": law_claims.law_is_justified,
    }


def _amplitude() -> Proof:
    """Whether every amplitude from 90 degrees on loses less than 1 % of the bound, and whether the zero of J0 does."""
    return Proof(
        printed=law_claims.largest_loss_from(paper.LEAST_AMPLITUDE) < 0.01,
        corrected=abs(mean_direction(QuasiHarmonic(amplitude=best_harmonic_amplitude(), period=60.0))) < 1e-6,
    )


def _gentle_ends() -> bool:
    """Whether twist at the reversals is less under the harmonic laws than at constant speed, of the same amplitude."""
    twist = law_study.encoder_table().loc["twist at reversals"].xs("sensor", level=1)
    return all(twist[f"harmonic, {a} deg"] < twist[f"constant speed, {a} deg"] for a in (90, 180))


def _requirements() -> dict:
    """Tables 2 and 3, beginning of chapter 3."""
    return {
        "table2-heading": paper.HEADING_ACCURACY / DEG,
        "table2-level": paper.LEVEL_ACCURACY / DEG,
        "table2-tilt": paper.LARGEST_TILT / DEG,
        "eq17-tan": requirement_claims.level_rates_give_heading,
        "eq17-singular": requirement_claims.headings_of_eq17,
        "limit-gyro": requirement_claims.gyro_error_allowed,
        "table3-bias": lambda: requirement_claims.alone("bias") * paper.REQUIRED_BIAS / DEG_PER_HOUR,
        "table3-scale": lambda: requirement_claims.alone("scale factor") * paper.REQUIRED_SCALE_FACTOR / PERCENT,
        "table3-noise": lambda: requirement_claims.alone("noise") * paper.REQUIRED_RANDOM_WALK / DEG_PER_SQRT_HOUR,
        "conclusion-4": requirement_claims.sensors_follow_from_heading,
    }


def _simulation() -> dict:
    """The simulation, chapter 3."""
    gyros = zip("xyz", paper.SIMULATED_BIASES, paper.SIMULATED_SCALE_FACTORS, strict=True)
    return {
        "sim-heading": paper.HEADING / DEG,
        "sim-trim": paper.TRIM / DEG,
        "sim-roll-mean": paper.ROLL_MEAN / DEG,
        "sim-roll-swing": paper.ROLL_SWING / DEG,
        "sim-roll-period": paper.ROLL_SWING_PERIOD,
        "sim-amplitude": paper.MOUNT_AMPLITUDE / DEG,
        "sim-period": paper.MOUNT_PERIOD,
        "sim-roll": _roll_of_the_vessel,
        "sim-duration": simulation.ASSUMED_DURATION,
        "claim-2": lambda: simulation_claims.all_is_observed_after_200_s() and verdicts.turning_shows_all(),
        "sim-zero": lambda: _ends_at_zero("heading", paper.HEADING_ACCURACY / DEG),
        "sim-zero-level": lambda: _ends_at_zero("level", paper.LEVEL_ACCURACY / ARCSEC),
        "sim-off-heading": simulation_claims.heading_is_hidden_while_off,
        "sim-off-bias": simulation_claims.biases_are_hidden_while_off,
        "sim-off-scale": simulation_claims.scale_factors_are_hidden_while_off,
        "sim-settling": simulation_claims.settling_time,
        "sim-on": simulation_claims.all_is_observed_after_200_s,
        "sim-much-smaller": simulation_claims.estimates_are_many_times_better,
        "sim-fig7-scale": simulation_claims.scale_factor_bound,
        "conclusion-2": simulation_claims.all_is_observed_after_200_s,
        "conclusion-5": simulation_claims.algorithm_works,
        **{
            f"table4-{gyro}-{name}": value
            for gyro, bias, scale in gyros
            for name, value in (
                ("bias", bias / DEG_PER_HOUR),
                ("scale", scale / PERCENT),
                ("noise", paper.SIMULATED_RANDOM_WALK / DEG_PER_SQRT_HOUR),
            )
        },
    }


def _roll_of_the_vessel() -> bool:
    """Whether the vessel's roll begins at its mean and is an amplitude above and below it a quarter of a period on."""
    roll = simulation.vessel().motion(paper.ROLL_SWING_PERIOD, paper.ROLL_SWING_PERIOD / 60).states[::15, 2]
    return bool(np.allclose(roll - paper.ROLL_MEAN, paper.ROLL_SWING * np.array([0, 1, 0, -1, 0]), atol=1e-12))


def _ends_at_zero(name: str, accuracy: float) -> bool:
    """Whether errors over 100 seeds end within a tenth of the accuracy that table 2 asks for."""
    return simulation_claims.errors_at_the_end()[name] < 0.1 * accuracy


def _experiments() -> dict:
    """The experiments, chapter 4."""
    return {
        "vg951-bias": paper.DATA_SHEET_BIAS / DEG_PER_SECOND,
        "vg951-scale": paper.DATA_SHEET_SCALE * DEG_PER_SECOND / 1e-3,
        "vg951-noise": paper.DATA_SHEET_NOISE / 1e-3,
        "vg951-range": paper.GYRO_RANGE / DEG_PER_SECOND,
        "exp2-amplitude": paper.EXPERIMENT_AMPLITUDE / DEG,
        "exp2-period": paper.EXPERIMENT_PERIOD,
        "exp1-level": experiment_verdicts.LEVEL / ARCSEC,
        "exp1-method": experiment_verdicts.scan_tells_heading,
        **{f"fig{14 + k}": (lambda k=k: experiment_verdicts.readings_are_harmonic(k)) for k in range(3)},
        **{
            f"table6-{name}": (lambda name=name: experiment_verdicts.scan_of_table_6()[name])
            for name in ("heading", *(f"{kind}-{gyro}" for kind in ("scale", "bias") for gyro in "xyz"))
        },
        "exp2-close": lambda: experiment_verdicts.accuracy() * ARCMIN / DEG,
        "exp2-time": lambda: experiment_verdicts.time_for_accuracy() / MINUTE,
        "exp2-accuracy": experiment_verdicts.accuracy,
        "exp2-contradiction": experiment_verdicts.agreement_shows_accuracy,
        "exp2-better": experiment_verdicts.accuracy_follows_noise,
        "exp2-confirms": experiment_verdicts.biases_confirmed,
        "ch4-middle-class": lambda: verdicts.middle_class_of_gyros() < 10,
    }
