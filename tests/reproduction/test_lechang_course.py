"""Does the velocity turn with the hull: stored runs, and a hull that yaws on its course."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.testing import assert_allclose

from fogkit.estimation.consistency import chi_square_interval
from fogkit.gyrocompass.covariance import Noise
from fogkit.gyrocompass.filters.records import record
from fogkit.gyrocompass.laws import QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.reproduction.lechang import course
from fogkit.units import DEG

ROOT = Path(__file__).parents[2]


def test_stored_runs_are_those_of_the_function():
    stored = pd.read_csv(ROOT / course.COURSE_RUNS)
    assert len(stored) == 600
    for name, follows in (("circle in 100 s", False), ("yawing by 5 deg, mount rocked", True)):
        again = course.course_case(name, 3, follows)
        (row,) = stored[(stored.way == name) & (stored.follows == follows) & (stored.seed == 3)].to_dict("records")
        numbers = ["nees", "heading_error", "predicted_std"]
        # five decimals are stored; other processors round another way
        assert_allclose([row[key] for key in numbers], [again[key] for key in numbers], rtol=1e-3, atol=1e-3)


def test_a_yawing_hull_reads_what_one_does_that_turns_where_it_lies():
    # at rest, where course says nothing: a hull turns clockwise by a law, its mount counter-clockwise by the same
    dt, sway, quiet = 0.01, QuasiHarmonic(amplitude=5 * DEG, period=10.0), Noise(angle_random_walk=0.0)
    hull = Vessel(lat=1.0, heading=0.7)
    turned = record(replace(hull, turning=sway).motion(20.0, dt, sway), quiet, np.random.default_rng(0))
    steady = record(hull.motion(20.0, dt), quiet, np.random.default_rng(0))
    found = course.yawing(steady, -sway.amplitude, sway.period)
    assert_allclose(found.mount_angle, turned.mount_angle, atol=1e-12)
    # of the Earth's rate in a step, 7e-7 rad, what an integral over the step leaves; of the hull's turn nothing
    assert_allclose(found.dtheta, turned.dtheta, atol=1e-9)
    assert np.abs(turned.dtheta).max() < 2e-6
    assert_allclose(found.dv, turned.dv, atol=1e-9)


def test_force_of_a_yawing_hull_is_that_seen_from_it():
    # level acceleration ahead; a hull turned counter-clockwise by 90 degrees has it to starboard
    dt = 0.01
    steady = record(Vessel(lat=1.0).motion(10.0, dt), Noise(angle_random_walk=0.0), np.random.default_rng(0))
    pushed = replace(steady, dv=np.tile([1.0, 0.0, 0.0], (len(steady.dv), 1)))
    found = course.yawing(pushed, np.pi / 2, 10.0)
    quarter = round(2.5 / dt)  # middle of the step after: 1.25e-5 of a quarter turn short of it
    assert_allclose(found.dv[quarter], [0.0, 0.0, 1.0], atol=1e-4)
    assert_allclose(np.linalg.norm(found.dv, axis=1), 1.0, rtol=1e-12)
    assert_allclose(found.dv[-1], [1.0, 0.0, 0.0], atol=0.01)


def test_filter_without_the_option_does_not_care_for_yawing(monkeypatch):
    # gyros that the mount has turned back feel nothing of it: the same heading to the noise of rounding in the tilt
    name = "yawing by 5 deg, mount rocked"
    yawed = course.course_case(name, 0, False)
    monkeypatch.setitem(course.WAYS, name, course.Way(mount=course.WAYS[name].mount))
    plain = course.course_case(name, 0, False)
    assert_allclose(yawed["heading_error"], plain["heading_error"], atol=0.01 * plain["predicted_std"])
    assert_allclose(yawed["predicted_std"], plain["predicted_std"], rtol=0.01)


def test_no_option_is_needed_with_heading_known_to_a_degree(monkeypatch):
    monkeypatch.setattr(course, "PRIOR", replace(course.PRIOR, heading=1 * DEG))
    low, high = chi_square_interval(17, 10, 0.999)
    for name in ("zig-zag by 45 deg", "circle in 100 s"):
        values = [course.course_case(name, seed, False)["nees"] for seed in range(10)]
        assert low < np.mean(values) < high


def test_table():
    table = course.by_way(pd.read_csv(ROOT / course.COURSE_RUNS))
    assert table.consistent.to_dict() == {
        (way, follows): follows != way.startswith("yawing") for way in course.WAYS for follows in (False, True)
    }
