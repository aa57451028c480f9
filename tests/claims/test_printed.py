"""What a printed number stands for."""

import math

import pytest

from fogkit.claims import Printed


@pytest.mark.parametrize(
    ("text", "value", "half_unit"),
    [
        ("0.214", 0.214, 0.0005),
        ("0,214", 0.214, 0.0005),
        ("12 500", 12500, 0.5),
        ("50\u00a0000", 50000, 0.5),
        ("-3.50", -3.5, 0.005),
        ("\u22123,5", -3.5, 0.05),
        ("+7", 7, 0.5),
        ("1.5e-3", 1.5e-3, 0.05e-3),
        ("1,5\u00b710^-3", 1.5e-3, 0.05e-3),
        ("2 x 10^{4}", 2e4, 0.5e4),
        ("3/4", 0.75, 0),
        ("pi/2", math.pi / 2, 0),
        ("7\u03c0/8", 7 * math.pi / 8, 0),
        ("-pi", -math.pi, 0),
    ],
)
def test_number_as_printed(text, value, half_unit):
    printed = Printed.parse(text)
    assert printed.low == printed.high == pytest.approx(value, rel=1e-15)
    assert printed.rounding == pytest.approx(half_unit, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("0.214", [0.2135, 0.2145, 0.214], [0.21349, 0.21451]),  # both ends of the rounding interval agree
        ("0.2140", [0.21395, 0.21405], [0.2139, 0.2141]),  # a printed zero counts
        ("<0.1", [-5, 0.0999], [0.1, 0.2]),
        ("<=0.1", [-5, 0.1], [0.1001]),
        ("\u22640,1", [0.1], [0.1001]),
        (">5", [5.01], [5, 4]),
        (">=5", [5], [4.99]),
        ("3..5", [3, 4, 5, 2.5, 5.5], [2.4, 5.6]),
        ("3\u20135", [4], [6]),
        ("100 to 50 000", [99.5, 20000], [99]),
        ("3/4", [0.75, 0.75 * (1 + 1e-15)], [0.7500001]),
    ],
)
def test_what_agrees(text, inside, outside):
    printed = Printed.parse(text)
    assert all(printed.contains(value) for value in inside)
    assert not any(printed.contains(value) for value in outside)


@pytest.mark.parametrize(
    ("text", "tolerance", "inside", "outside"),
    [
        ("200", "10", [190, 210], [189, 211]),
        ("200", "1%", [198, 202], [197.9, 202.1]),
        ("-200", "1%", [-198, -202], [-197.9, 198]),
        ("<0.1", "0.01", [0.1, 0.11], [0.111]),  # a tolerance widens a bound
        ("100", "0", [100], [100.001]),  # and may be narrower than the print's rounding
    ],
)
def test_tolerance_replaces_the_rounding(text, tolerance, inside, outside):
    printed = Printed.parse(text)
    assert all(printed.contains(value, tolerance) for value in inside)
    assert not any(printed.contains(value, tolerance) for value in outside)


@pytest.mark.parametrize(
    "text", ["", "about 3", "0.214 deg/h", "1.2.3", "12 50", "1,234,567", "3..", "<", "nan", "-1/2/3"]
)
def test_anything_else_is_not_a_number(text):
    with pytest.raises(ValueError, match="not a number"):
        Printed.parse(text)


def test_range_downwards():
    with pytest.raises(ValueError, match="downwards"):
        Printed.parse("5..3")
