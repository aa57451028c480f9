"""Units by name, as a description of a recording gives them: which there are, and what each is in SI.

A name is taken as it stands, capitals included; there is no default. The nearest known name is suggested, never used.

Examples
--------
>>> si_factor("angular rate", "deg/h")
4.84813681109536e-06
>>> si_factor("acceleration", "m/s/s")
Traceback (most recent call last):
    ...
ValueError: `unit` must name a unit of acceleration, got 'm/s/s'. Did you mean 'm/s^2'?
"""

from difflib import get_close_matches
from typing import Any

from fogkit.constants import STANDARD_GRAVITY
from fogkit.units import (
    ARCMIN,
    ARCSEC,
    CENTIMETRE,
    DEG,
    DEG_PER_HOUR,
    DEG_PER_SECOND,
    HOUR,
    MICRO_G,
    MICROSECOND,
    MILLI_G,
    MILLIMETRE,
    MILLISECOND,
    MINUTE,
    NANOSECOND,
    REVOLUTION,
)

UNITS: dict[str, dict[str, float]] = {
    "angular rate": {
        "rad/s": 1.0,
        "mrad/s": 1e-3,
        "urad/s": 1e-6,
        "deg/s": DEG_PER_SECOND,
        "deg/min": DEG / MINUTE,
        "deg/h": DEG_PER_HOUR,
        "arcmin/s": ARCMIN,
        "arcsec/s": ARCSEC,
        "rev/s": REVOLUTION,
        "rev/min": REVOLUTION / MINUTE,
    },
    "angle": {
        "rad": 1.0,
        "mrad": 1e-3,
        "urad": 1e-6,
        "deg": DEG,
        "arcmin": ARCMIN,
        "arcsec": ARCSEC,
        "rev": REVOLUTION,
    },
    "acceleration": {
        "m/s^2": 1.0,
        "cm/s^2": CENTIMETRE,
        "mm/s^2": MILLIMETRE,
        "g": STANDARD_GRAVITY,
        "mg": MILLI_G,
        "ug": MICRO_G,
    },
    "velocity": {
        "m/s": 1.0,
        "cm/s": CENTIMETRE,
        "mm/s": MILLIMETRE,
        "g*s": STANDARD_GRAVITY,
        "mg*s": MILLI_G,
        "ug*s": MICRO_G,
    },
    "time": {
        "s": 1.0,
        "ms": MILLISECOND,
        "us": MICROSECOND,
        "ns": NANOSECOND,
        "min": MINUTE,
        "h": HOUR,
    },
    "temperature": {"degC": 1.0, "K": 1.0, "degF": 5 / 9},
}
"""Factor to SI of each name, by kind of quantity; to degC, up to its `ZERO`, for a temperature."""

ZERO = {"degC": 0.0, "K": -273.15, "degF": -160 / 9}
"""Temperature, degC, of the zero of each scale."""


def checked_unit(kind: str, name: Any, argument: str = "unit") -> str:
    """Name of a unit of some kind; ``ValueError`` with the nearest known name if it is none of them."""
    known = UNITS[kind]
    if not isinstance(name, str):
        raise TypeError(f"`{argument}` must be the name of a unit of {kind}, got {name!r}")
    if name not in known:
        near = get_close_matches(name, known, n=1, cutoff=0.5)
        folded = [unit for unit in known if unit.casefold() == name.casefold()]
        other = [other for other, units in UNITS.items() if name in units]
        hint = f" Did you mean {(folded or near)[0]!r}?" if folded or near else f" Known are {', '.join(known)}."
        hint = f" That is a unit of {other[0]}. Known are {', '.join(known)}." if other else hint
        raise ValueError(f"`{argument}` must name a unit of {kind}, got {name[:40]!r}.{hint}")
    return name


def si_factor(kind: str, name: str) -> float:
    """SI value of one unit; ``ValueError`` as `checked_unit`."""
    return UNITS[kind][checked_unit(kind, name)]
