"""The slides' claims about positions and rates on the example unit, against closed forms."""

import numpy as np
import pytest

from fogkit.constants import EARTH_RATE
from fogkit.reproduction.beihang import laboratory
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_SECOND, MINUTE, PPM

LATITUDE = 40 * DEG
NORTH, UP = EARTH_RATE * np.cos(LATITUDE), EARTH_RATE * np.sin(LATITUDE)
GRAVITY = laboratory.PLACE.gravity


def orders(disturbance, plan):
    return {group: effect.order for group, effect in laboratory.disturbed(disturbance, plan=plan).items()}


def test_azimuth_does_not_matter_to_the_24_points():
    assert set(orders("plate turned in azimuth", "24 points").values()) == {0}
    assert orders("plate turned in azimuth", "six positions")["gyro bias"] == 1


@pytest.mark.parametrize("tilt", ["plate tilted about east", "plate tilted about north"])
def test_tilts_that_stay_in_the_room_cancel_but_for_gravity_and_the_earths_rate_along_the_normal(tilt):
    effects = laboratory.disturbed(tilt, ARCMIN)
    for group in ("accelerometer bias", "accelerometer cosines", "gyro bias", "gyro equivalent", "gyro cosines"):
        assert effects[group].order == 0
    equivalent = effects["accelerometer equivalent"]
    assert equivalent.order == 2
    assert equivalent.error == pytest.approx(1 - np.cos(ARCMIN), rel=1e-4)  # rounding of 1e-12 in 4e-8
    sensitivity = effects["gyro acceleration sensitivity"]
    assert sensitivity.order == (1 if "east" in tilt else 2)
    expected = NORTH * np.sin(ARCMIN) if "east" in tilt else UP * (1 - np.cos(ARCMIN))
    # the example's gyros point 5 arcmin off: 1e-3 of it in other entries; the second order of gravity stands beside it
    if "east" in tilt:
        assert sensitivity.error == pytest.approx(expected / GRAVITY, rel=2e-3)


def test_what_turns_with_the_unit_is_not_cancelled():
    mounted = laboratory.disturbed("unit turned in the cube", ARCMIN)
    for kind in ("accelerometer", "gyro"):
        assert mounted[f"{kind} cosines"].order == 1
        assert mounted[f"{kind} cosines"].error == pytest.approx(ARCMIN, rel=2e-3)  # the largest angle is one of 1
        assert mounted[f"{kind} bias"].order == 0
    faces = {
        plan: laboratory.disturbed("faces of the cube not square", plan=plan) for plan in ("24 points", "six positions")
    }
    for group in ("accelerometer bias", "accelerometer cosines"):
        errors = [faces[plan][group].error for plan in faces]
        assert errors[0] == pytest.approx(errors[1], rel=1e-9)
        assert faces["24 points"][group].order == 1


def test_efforts_are_counted():
    points, rates = laboratory.efforts(point=2 * MINUTE).values()
    assert (points.placements, rates.placements) == (24 + 3, 6 + 3 + 3)
    assert points.reading == pytest.approx(24 * 120 + 6 * 36)
    assert rates.reading == pytest.approx(6 * 120 + 3 * 600 + 3 * 29 * 120)
    handling = laboratory.handling_that_evens()
    assert points.total(handling) == pytest.approx(rates.total(handling))


def test_one_turn_knows_neither_the_cubic_term_nor_the_angle_better():
    ways = laboratory.scale_factor_errors(turn_rate=10 * DEG_PER_SECOND)
    turn, line, shaped = ways.values()
    full, slow = 200 * DEG_PER_SECOND, 10 * DEG_PER_SECOND
    cubic, asymmetry = laboratory.GYRO_SHAPE.cubic[0], laboratory.GYRO_SHAPE.asymmetry[0]
    expected = cubic * (full**2 - slow**2) + asymmetry / 2  # the difference of both directions hides the asymmetry
    assert turn.at_full_rate == pytest.approx(expected, rel=1e-3)
    assert abs(shaped.at_full_rate) < 1 * PPM < abs(line.at_full_rate) < abs(turn.at_full_rate)
    assert max(line.noise, shaped.noise) < turn.noise


def test_deviations_of_the_scale_factor_are_those_of_noise_angle_and_table():
    turn, line, _ = laboratory.scale_factor_errors(
        turn_rate=10 * DEG_PER_SECOND, turn_error=10 * ARCSEC, rate_error=5 * PPM
    ).values()
    noise = laboratory.GYRO_NOISE
    in_turn = noise.allan_variance(36.0) / (10 * DEG_PER_SECOND) ** 2 + (10 * ARCSEC / (2 * np.pi)) ** 2
    assert turn.noise == pytest.approx(np.sqrt(in_turn / 2), rel=1e-9)
    sizes = np.array([0.1, 0.2, 0.5, 1, 3, 5, 8, 10, 20, 50, 80, 100, 150, 200]) * DEG_PER_SECOND
    rates = np.concatenate([[0.0], sizes, -sizes])
    weights = 1 / (noise.allan_variance(120.0) + (5 * PPM * rates) ** 2)
    spread = rates - np.average(rates, weights=weights)
    # the fit adds the Earth's vertical rate, the same to all, and estimates the scale factor to 1e-3 beforehand
    assert line.noise == pytest.approx((weights * spread**2).sum() ** -0.5, rel=2e-3)


def test_a_position_to_the_east_feels_azimuth_by_the_north_rate_and_level_by_the_vertical_one():
    budget = laboratory.east_bias_budget(error=ARCMIN)
    assert budget.azimuth == pytest.approx(NORTH * np.sin(ARCMIN), rel=1e-9)
    assert budget.level == pytest.approx(UP * np.sin(ARCMIN), rel=1e-9)
    assert budget.noise == pytest.approx(np.sqrt(laboratory.GYRO_NOISE.allan_variance(600.0)))


def test_gravity_on_a_tilted_plate():
    assert laboratory.gravity_of_a_tilt(0.01) == pytest.approx(1 - np.cos(0.01), rel=1e-10)


def test_without_the_earth_150_is_best_of_the_fast_rates():
    runs = {round(run.rate / DEG_PER_SECOND, 1): run for run in laboratory.installation_runs(runs=4)}
    left_out = {rate: run.without_earth for rate, run in runs.items()}
    assert min(left_out, key=left_out.get) == 150
    assert left_out[3] < left_out[1] / 100  # a whole turn
    # at whole turns it makes no difference whether the Earth is counted
    assert left_out[150] == pytest.approx(runs[150].spread, rel=0.01)
