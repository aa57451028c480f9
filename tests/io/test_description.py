"""`recording.toml`: what it may say, and the one sentence where it may not."""

import numpy as np
import pytest

from fogkit import io
from fogkit.io.plan_names import PARAMETERS, steps
from fogkit.io.unit_names import UNITS, si_factor
from fogkit.units import DEG

WHOLE = """
version = 1
[file]
path = "data/unit7.csv"
delimiter = ";"
decimal = ","
[clock]
column = "t"
unit = "ms"
sample_rate = 100
second_column = "gps"
second_unit = "s"
[gyro]
columns = ["w1", "w2", "w3"]
unit = "arcsec"
quantity = "increments"
axes = ["x", "-z", "y"]
scale = 0.5
[accel]
columns = ["a 1", "a \\"2\\"", "ä3"]
unit = "g"
[temperature]
unit = "K"
coil = "T1"
[angle]
column = "table"
unit = "deg"
[place]
latitude = 59.9
latitude_unit = "deg"
gravity = 9.819
[plan]
kind = "six-positions"
duration = 30
"""

PLANS = {
    "three-stage": {"bias_duration": 60.0, "rates": [36.0, -36.0], "rate_unit": "deg/s", "count": 3},
    "six-positions": {"duration": 10.0},
    "twenty-four-points": {"duration": 10.0},
    "three-positions-east": {"duration": 10.0},
    "full-turns": {"rate": 10.0, "rate_unit": "deg/s", "turns": 2},
    "rate-sequence": {"duration": 5.0, "rates": [1.0, -1.0], "rate_unit": "deg/s", "axes": "xz"},
    "placements": {"placements": [["a", "ENU", 5.0, 0.0], ["b", "UEN", 5.0, 3.0]], "rate_unit": "deg/s"},
    "nine-tests": {"turns": 1, "dwell": 5.0},
    "bias-test": {"dwell": 20.0},
    "gyrocompass": {
        **{"start": "ENU", "axis": "x", "angles": [0.0, 180.0], "angle_unit": "deg"},
        **{"dwell": 5.0, "turn_duration": 2.0},
    },
}


def test_a_whole_description():
    found = io.RecordingDescription.from_toml(WHOLE)
    assert found.file.kind == "csv" and found.file.delimiter == ";"
    # 0.5 arcsec per count in 10 ms; the second column is the negative z axis
    sources = found.sources(0.01)
    assert sources["gyro_x"] == ("w1", pytest.approx(0.5 * DEG / 3600 / 0.01), 0.0)
    assert sources["gyro_y"][0] == "w3" and sources["gyro_y"][1] > 0
    assert sources["gyro_z"][0] == "w2" and sources["gyro_z"][1] < 0
    assert sources["temperature_coil"] == ("T1", 1.0, -273.15)
    assert found.latitude == pytest.approx(59.9 * DEG, rel=1e-15)
    assert found.names[-3:] == ("temperature_coil", "angle", "clock")


def test_text_round_trip():
    found = io.RecordingDescription.from_toml(WHOLE)
    assert io.RecordingDescription.from_toml(found.to_toml()) == found


def test_every_kind_of_plan_is_tried():
    assert PLANS.keys() == PARAMETERS.keys()


@pytest.mark.parametrize("kind", PLANS)
def test_plans_round_trip_and_have_steps(kind):
    plan = io.PlanReference(kind=kind, parameters=PLANS[kind])
    text = WHOLE.partition("[plan]")[0]
    description = io.RecordingDescription.from_toml(text)
    object.__setattr__(description, "plan", plan)
    assert io.RecordingDescription.from_toml(description.to_toml()).plan == plan
    for step in steps(plan.build()):
        assert step.duration > 0
        assert step.up is None or np.linalg.norm(step.up) == pytest.approx(1, abs=1e-12)


def test_up_after_a_turn_is_where_the_turn_takes_it():
    plan = io.PlanReference(kind="gyrocompass", parameters=PLANS["gyrocompass"] | {"angles": [0.0, 90.0]})
    before, turn, after = steps(plan.build())
    assert before.up == (0, 0, 1) and turn.rate == pytest.approx((np.pi / 4, 0, 0))
    assert after.up == pytest.approx((0, 1, 0), abs=1e-12)  # +90 deg about x brings y up


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("version = 1", "version = 2", "`version` must be 1, got 2"),
        ("version = 1", "", "`version` must be given"),
        (
            'unit = "arcsec"',
            'unit = "arcsecs"',
            "[gyro]: `unit` must name a unit of angle, got 'arcsecs'. Did you mean 'arcsec'?",
        ),
        ('unit = "arcsec"', 'unit = "deg/s"', "That is a unit of angular rate"),
        ('unit = "g"', 'unit = "G"', "Did you mean 'g'?"),
        ('"w2"', '"w1"', "column 'w1' must stand for one thing only"),
        ('"w2"', "7", "columns of this file must be names, got 7"),
        ('"-z"', '"-x"', "`axes` must name x, y and z once each"),
        ("decimal", "decimale", "[file]: `decimale` is not a known key. Did you mean `decimal`?"),
        ("sample_rate = 100", "sample_rate = true", "[clock]: `sample_rate` must be a real number, got True"),
        ("sample_rate = 100", "sample_rate = 1" + "0" * 400, "recording.toml"),
        ('latitude_unit = "deg"', "", "`latitude_unit` must be given with `latitude`"),
        ('latitude_unit = "deg"', 'latitude_unit = "rad"', "`latitude` must be in"),
        ("gravity = 9.819", "gravity = 1.0", "`gravity` must be in [9.7, 9.9]"),
        ("six-positions", "six-position", "Did you mean 'six-positions'?"),
        ("duration = 30", "durations = 30", "`durations` is not a parameter of 'six-positions'"),
        ("duration = 30", "duration = -1", "[plan]: `duration` must be in"),
        ("[clock]", "[clocks]", "`clocks` is not a known key. Did you mean `clock`?"),
        ("[file]", "[file", "is not valid TOML"),
        ('path = "data/unit7.csv"', 'path = "data/unit7.xls"', "The suffix '.xls' of `path` does not say it"),
        ('delimiter = ";"', 'delimiter = ","', "`delimiter` and `decimal` must differ"),
    ],
)
def test_errors_are_one_sentence_that_names_the_place(old, new, words):
    with pytest.raises(io.RecordingError) as caught:
        io.RecordingDescription.from_toml(WHOLE.replace(old, new, 1))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_rates_of_a_plan_need_their_unit():
    with pytest.raises(ValueError, match="`rate_unit` must be given with `rates`"):
        io.PlanReference(kind="rate-sequence", parameters={"rates": [1.0]})


def test_units_by_name_against_their_definitions():
    assert si_factor("angular rate", "deg/h") == pytest.approx(np.pi / 180 / 3600, rel=1e-15)
    assert si_factor("angular rate", "rev/min") == pytest.approx(2 * np.pi / 60, rel=1e-15)
    assert si_factor("velocity", "mg*s") == pytest.approx(9.80665e-3, rel=1e-15)
    assert all(factor > 0 for units in UNITS.values() for factor in units.values())


def test_the_file_itself(tmp_path):
    with pytest.raises(io.RecordingError, match=r"recording\.toml cannot be read"):
        io.read_description(tmp_path / "recording.toml")
    (tmp_path / "recording.toml").write_bytes(WHOLE.encode("utf-16"))
    with pytest.raises(io.RecordingError, match="must be UTF-8"):
        io.read_description(tmp_path / "recording.toml")
