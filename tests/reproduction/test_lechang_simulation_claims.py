"""What the thesis says of its simulation: that the statements can fail, and the numbers beside closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.gyrocompass.accuracy import heading_bound
from fogkit.reproduction.lechang import paper, simulation, simulation_claims
from fogkit.units import DEG


def test_verdicts():
    assert simulation_claims.heading_is_hidden_while_off()
    assert not simulation_claims.biases_are_hidden_while_off()
    assert not simulation_claims.scale_factors_are_hidden_while_off()
    assert not simulation_claims.angle_errors_go_to_zero()
    assert simulation_claims.all_is_observed_after_200_s()
    assert not simulation_claims.all_is_settled_after_200_s()
    assert simulation_claims.estimates_are_many_times_better()
    assert simulation_claims.algorithm_works()
    assert simulation_claims.filter_may_be_believed("wander", 400)
    assert not simulation_claims.filter_may_be_believed("extended", 400)


def test_settling_time_is_about_the_printed_one():
    # two periods of the mount; the criterion, a tenth, is ours, hence a tenth of the print is allowed
    assert abs(simulation_claims.settling_time() - paper.SETTLING_TIME) < 20
    times = [simulation_claims.time_to(aid)["heading"] for aid in simulation_claims.AIDS]
    assert times == sorted(times)  # a poorer aid takes longer


def test_noise_floor_is_the_bound_of_the_best_law():
    bound = heading_bound(simulation.mount(), 900.0, paper.ASSUMED_LATITUDE, paper.SIMULATED_RANDOM_WALK, bias_std=0.0)
    assert_allclose(simulation_claims.heading_noise_floor(900.0) * DEG, bound.std, rtol=1e-9)
    assert simulation_claims.errors_at_the_end()["heading"] > simulation_claims.heading_noise_floor()


def test_heading_falls_as_the_root_of_time_once_biases_are_averaged():
    heading = simulation_claims.phases(0.01)[1].of("heading")
    fall = np.log(heading[200] / heading[500]) / np.log(500 / 200)
    assert_allclose(fall, 0.5, atol=0.1)  # the 400 s before count as well, so not quite


def test_scale_factors():
    at = simulation_claims.scale_factors_within()
    scale = simulation_claims.phases(0.01)[1].std[:, 12:].max(axis=1)
    assert (3 * scale[int(at) :] < 3e-4).all() and 3 * scale[int(at) - 1] >= 3e-4
    assert simulation_claims.scale_factor_bound() < 0.03
    assert simulation_claims.scale_factors_within(1e-9) == np.inf
    assert simulation_claims.scale_factors_within(1.0) == 0.0


def test_unaided_errors_grow():
    growth = simulation_claims.unaided_growth()
    assert simulation_claims.aid_bounds_errors() and growth["height"] > 100
    assert simulation_claims.pyramid_shows_all()
    assert not simulation_claims.cube_hides_level_gyros()


@pytest.mark.parametrize("name", ["wander", "extended"])
def test_errors_of_table_4_shrink(name):
    least = simulation_claims.errors_over_rest(name)
    end = simulation_claims.errors_at_the_end(name)
    assert_allclose(least, 4.0 / end["bias"], rtol=0.05)  # the smallest bias over errors that are nearly alike
