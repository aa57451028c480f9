"""What the rows of the ledger rest on: that each is computed, and each check by another route, or seen to fail."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from fogkit import claims
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import error_model, frames, mechanisation, scan
from fogkit.reproduction import lechang
from fogkit.reproduction.lechang import paper, requirement_claims, requirements, turns, verdicts
from fogkit.units import DEG, MINUTE

ROWS = {claim.id: claim for claim in claims.load("lechang")}
VALUES = lechang.values()


def test_every_row_is_computed_or_says_why_not():
    assert set(VALUES) <= set(ROWS)
    for name, row in ROWS.items():
        if name not in VALUES:
            assert row.status in ("undetermined", "definition"), name
        assert "PROVISIONAL" not in row.note
        assert "to come" not in row.note
        assert row.note or row.status == "reproduced", name


def test_every_equation_table_and_figure_has_a_row():
    names = " ".join(ROWS)
    for number in range(1, 18):
        assert f"lechang-eq{number:02d}" in names
    for number in range(1, 20):
        assert f"lechang-fig{number:02d}" in names
    cells = {1: 12, 2: 3, 3: 3, 4: 9, 5: 8, 6: 7}
    for table, count in cells.items():
        assert sum(name.startswith(f"lechang-table{table}-") for name in ROWS) >= count


def test_a_wrong_equation_departs_from_turns(monkeypatch):
    assert max(turns.departures().values()) < turns.TOLERANCE
    right = mechanisation.angle_rates
    monkeypatch.setattr(mechanisation, "angle_rates", lambda *a: right(*a) * [-1, 1, 1])  # the lost minus sign of (6)
    assert not turns.follows("eq06")
    assert turns.follows("eq03")
    assert turns.angles_by_integration() > 0.1
    monkeypatch.setattr(mechanisation, "geographic_rate", lambda *a: np.array([1.0, 1.0, -1.0]) * EARTH_RATE)
    assert not turns.follows("eq05")
    assert not turns.follows("eq04")
    wrong = frames.mount_attitude
    monkeypatch.setattr(mechanisation, "mount_attitude", lambda angle: wrong(-np.asarray(angle)))
    assert not turns.follows("eq03")


def test_integration_of_rates_is_of_fourth_order():
    # the angles are quadratic in time, the rates of them by (6) exact to 1e-9: what is left is Simpson's rule
    coarse, fine = (turns.angles_by_integration(steps=steps) for steps in (2, 10))
    assert fine <= coarse < 1e-7


def test_a_wrong_coefficient_departs_from_differences(monkeypatch):
    assert turns.error_model_departure() < 1e-7
    right = error_model.system_matrix

    def wrong(state, reading):
        F = right(state, reading)
        F[0, 6] *= 1 + 1e-4
        F[:9, 12] *= 1 + 1e-4
        return F

    monkeypatch.setattr(error_model, "system_matrix", wrong)
    turns.error_model_departure.cache_clear()
    assert turns.error_model_departure() > 5e-5
    assert not turns.errors_of_a_gyro_act_alike()
    turns.error_model_departure.cache_clear()


def test_rates_near_a_vertical_bow_grow_as_the_secant():
    for trim in (60 * DEG, 84 * DEG, 89.9 * DEG):
        assert_allclose(turns.rates_near_a_vertical_bow(trim), 1 / np.cos(trim), rtol=1e-12)


def test_euler_angles_make_the_pyramid():
    psi, theta, gamma = verdicts.euler_angles()
    assert_allclose(frames.pyramid_axes(np.array([psi, theta, gamma]) * DEG), frames.pyramid_axes(), atol=1e-12)
    assert_allclose(theta, np.rad2deg(np.arctan(np.sqrt(2))), rtol=1e-12)
    assert_allclose(verdicts.inclination_that_is_orthogonal(), np.rad2deg(np.arccos(3**-0.5)), atol=1e-6)
    assert verdicts.sign_of_eq13(0.0) == -verdicts.sign_of_eq13(180.0) == -1


def test_axis_of_a_pendulous_compass_rises_in_the_east(monkeypatch):
    assert verdicts.pendulum_seeks_the_meridian()
    # closed form of the rise: the Earth's level rate times the time
    lat = 45 * DEG
    turn = -EARTH_RATE * MINUTE * np.array([np.cos(lat), np.sin(lat), 0.0])
    rise = Rotation.from_rotvec(turn).apply([0.0, 0.0, 1.0])[1]
    assert_allclose(rise, EARTH_RATE * np.cos(lat) * MINUTE, rtol=1e-4)
    monkeypatch.setattr(verdicts, "EARTH_RATE", -EARTH_RATE)  # an Earth that turns the other way
    assert not verdicts.pendulum_seeks_the_meridian()


def test_fixed_unit_hides_east_bias_and_heading_together():
    # heading and the east bias read alike: what is left of both is in the ratio of the level Earth rate, 1 : U cos(lat)
    from fogkit.reproduction.lechang import simulation

    fractions, directions = simulation.unseen(None, rolling=False)
    hidden = directions[:, fractions > 0.95]
    together = hidden @ hidden[0]  # the direction of heading, as far as it is hidden, in units of the prior
    prior_heading, prior_bias = 10 * DEG, 10 * DEG / 3600
    bias = together[1:4] * prior_bias
    east = (frames.hull_attitude(paper.HEADING, paper.TRIM, paper.ROLL_MEAN) @ frames.pyramid_axes())[2]
    level = EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)
    # 2 % : what 400 s of the Earth's turn let be told of a bias that is 0.1 of its prior
    assert_allclose(bias, -together[0] * prior_heading * level * east, rtol=0.02, atol=0.02 * prior_bias)


def test_what_a_cube_hides():
    at_rest = verdicts.left_of(mount=True, rolling=False, cube=True)
    # level gyros on a cube do not see the mount's rate: only the Earth's, which is 1 % of 7.5 deg/h at most
    assert at_rest["scale_factor_x"] > 0.4
    assert at_rest["scale_factor_y"] < 1e-3
    assert verdicts.left_of(mount=True, rolling=True, cube=True)["scale_factor_x"] < 1e-3
    assert not verdicts.cube_shows_azimuth_gyro_only()
    assert verdicts.cube_hides_an_error()
    assert not verdicts.left_of(mount=False, rolling=False)["heading"] < 0.95


def test_second_equation_sees_half_the_circle():
    assert verdicts.eq02_inverts_eq01()
    west = float(scan.level_reading(-1.0, 1.0))
    assert_allclose(scan.azimuths(west, 1.0), [1.0, -1.0], rtol=1e-12)


def test_proofs_by_sense_and_axis():
    assert verdicts.sense_of_the_mount()
    assert verdicts.mount_stands_on_the_normal() == claims.Proof(printed=False, corrected=True)


def test_requirements_in_words(monkeypatch):
    assert_allclose(requirement_claims.gyro_error_allowed(60 * DEG), 15.041 * 0.5 * np.tan(0.3 * DEG), rtol=1e-4)
    assert requirement_claims.tilts_leave_room()
    assert requirement_claims.headings_of_eq17()
    assert requirement_claims.level_rates_give_heading()
    assert not requirement_claims.sensors_follow_from_heading()
    # what a term may be alone, put back into the gyro error of table 3, is that of table 2
    bias = requirement_claims.alone("bias") * paper.REQUIRED_BIAS
    assert_allclose(requirements.heading_error(bias, paper.ASSUMED_LATITUDE), paper.HEADING_ACCURACY, rtol=1e-12)
    monkeypatch.setattr(paper, "GYRO_ERROR_LIMIT", 0.07 * DEG / 3600)
    assert requirement_claims.sensors_follow_from_heading()
    monkeypatch.setattr(paper, "LEVEL_ACCURACY", 0.02 * DEG)  # arctan 15, not arctan 3
    assert not requirement_claims.tilts_leave_room()
