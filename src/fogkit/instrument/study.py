"""All grades on all stands by all methods, many units of each: what is left of each error, and what it does to heading.

`RUNS` holds the outcome of ``runs(range(10))``, written by ``python -m fogkit.instrument.study PATH``.
"""

import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fogkit.gyrocompass.accuracy import best_harmonic_amplitude
from fogkit.gyrocompass.laws import ConstantSpeedReversal, QuasiHarmonic
from fogkit.instrument.description import Conditions, Instrument
from fogkit.instrument.errors_left import BIASES, PARTS, ErrorsLeft, errors_left
from fogkit.instrument.grades import GRADES
from fogkit.instrument.heading import Knowledge, Task, at_rest, on_mount
from fogkit.instrument.methods import METHODS, Calibrated, calibrate
from fogkit.instrument.stands import STANDS, Stand
from fogkit.instrument.temperature import temperature_test
from fogkit.thermal.experiment import CoilBias
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, MICRO_G, MINUTE, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

RUNS = "data/derived/instrument_runs.csv"
SEEDS = 10
LATITUDE = 60 * DEG
SEA = Conditions(acceleration=(2000 * DEG_PER_SECOND_SQUARED,) * 3, chamber=5.0, powered=30 * MINUTE)
"""Where the unit works: shaken by an engine at 60 Hz, half an hour after switching on in the cold."""

TASKS = {
    "rocking": Task(lat=LATITUDE, law=QuasiHarmonic(amplitude=best_harmonic_amplitude(), period=60.0)),
    "reversal": Task(lat=LATITUDE, law=ConstantSpeedReversal(amplitude=np.pi, period=60.0)),
}
"""Five minutes with the mount rocked, or turned at constant speed and back; both laws have the mean direction zero."""

NO_MODEL, NOISE, ALL = "temperature, no model", "noise", "all"
ROWS = (*PARTS, NO_MODEL, NOISE, ALL)
UNITS = dict.fromkeys((*BIASES, NO_MODEL), (DEG_PER_HOUR, "deg/h")) | {
    "scale factor": (PPM, "ppm"),
    "asymmetry": (PPM, "ppm"),
    "misalignment": (ARCSEC, "arcsec"),
    "accelerometers": (MICRO_G, "micro-g"),
}
"""Units of the column ``size`` of a table of runs."""


@cache
def drawn(grade: str, seed: int) -> tuple[Instrument, tuple[CoilBias, ...], np.ndarray]:
    """A unit of a grade, what its temperature test found, and its biases' change at sea, rad/s."""
    kind, rng = GRADES[grade], np.random.default_rng([seed, list(GRADES).index(grade)])
    unit = kind.draw(rng)
    models = temperature_test(unit, rng, repeatability=kind.repeatability)
    return unit, models, kind.repeatability * rng.standard_normal(3)


def conditions_on(stand: Stand) -> Conditions:
    """Settled at 25 degC, shaken by the stand."""
    return Conditions(acceleration=(stand.acceleration,) * 3)


@cache
def calibrated_unit(grade: str, stand: str, method: str, seed: int) -> Calibrated:
    """What a method finds of a unit on a stand."""
    unit, _, _ = drawn(grade, seed)
    place = STANDS[stand]
    rng = np.random.default_rng([seed, *(list(names).index(n) for names, n in ((STANDS, stand), (METHODS, method)))])
    return calibrate(method, unit.at(conditions_on(place)), place, LATITUDE, rng)


def left_at_sea(grade: str, stand: str, method: str, seed: int, *, with_model: bool = True) -> ErrorsLeft:
    """Errors that are left of a unit at sea, with or without the model of the temperature test."""
    unit, models, change = drawn(grade, seed)
    return errors_left(
        unit,
        calibrated_unit(grade, stand, method, seed),
        conditions_on(STANDS[stand]),
        SEA,
        repeatability=change,
        thermal_models=models if with_model else None,
    )


def size(left: ErrorsLeft, row: str) -> float:
    """Root mean square of an error that is left over the three sensors, in SI units; NaN for rows that hold several."""
    if row in (NOISE, ALL):
        return np.nan
    off = ~np.eye(3, dtype=bool)
    values = {
        "scale factor": np.diag(left.matrix),
        "asymmetry": left.asymmetry,
        "misalignment": left.matrix[off],
        "accelerometers": left.forces(9.80665 * np.eye(3))[off] if row == "accelerometers" else 0.0,
    } | left.biases
    return float(np.sqrt(np.mean(np.square(values["temperature" if row == NO_MODEL else row]))))


def known_of(lefts: Iterable[ErrorsLeft]) -> Knowledge:
    """What a user may know beforehand of units calibrated alike: the root mean squares over them."""
    lefts = list(lefts)
    bias = np.sqrt(np.mean([left.bias**2 for left in lefts]))
    scale = np.sqrt(np.mean([(left.matrix**2).sum(axis=1) for left in lefts]))
    return Knowledge(bias=float(bias), scale_factor=float(scale))


def case(grade: str, stand: str, method: str, seeds: Iterable[int]) -> list[dict]:
    """All rows of one grade, stand and method."""
    seeds = tuple(seeds)
    known = known_of(left_at_sea(grade, stand, method, seed) for seed in seeds)
    return [row for seed in seeds for row in unit_rows(grade, stand, method, seed, known)]


def unit_rows(grade: str, stand: str, method: str, seed: int, known: Knowledge) -> list[dict]:
    """Rows of one unit: sizes of errors by `UNITS`, heading errors in degrees, and what the filter knew, deg/h, ppm."""
    left = left_at_sea(grade, stand, method, seed)
    raw = left_at_sea(grade, stand, method, seed, with_model=False)
    random = drawn(grade, seed)[0].at(SEA, simulated=False).gyros.random
    names = {"grade": grade, "stand": stand, "method": method, "seed": seed}
    stated = {"known_bias": known.bias / DEG_PER_HOUR, "known_scale": known.scale_factor / PPM}
    rows = []
    for row in ROWS:
        kept = {NO_MODEL: raw.only("temperature"), ALL: left, NOISE: _nothing(left)}.get(row)
        kept = left.only(row) if kept is None else kept
        errors = heading_errors(kept, known, random.angle_random_walk, random if row in (NOISE, ALL) else None, seed)
        found = {"size": size(kept, row) / UNITS.get(row, (1.0, ""))[0]}
        rows.append(names | {"part": row} | found | errors | stated)
    return rows


def heading_errors(left: ErrorsLeft, known: Knowledge, walk: float, random=None, seed: int = 0) -> dict[str, float]:
    """Errors of heading, degrees: at rest, rocked, and by reversal."""
    seeds = iter(np.random.SeedSequence([seed, 77]).spawn(3))

    def rng():
        return np.random.default_rng(next(seeds))

    found = {"rest": at_rest(left, TASKS["rocking"], random, rng())}
    found |= {name: on_mount(left, task, walk, known, random, rng()) for name, task in TASKS.items()}
    return {name: value / DEG for name, value in found.items()}


def cases() -> list[tuple[str, str, str]]:
    """Grade, stand and method of each case; without calibration there is no stand."""
    calibrated = [(g, s, m) for g in GRADES for s in STANDS for m in METHODS if m != "none"]
    return [(g, "ideal", "none") for g in GRADES] + calibrated


def runs(seeds: Iterable[int], report: Callable[[str], None] | None = None) -> "DataFrame":
    """`case` of all `cases`: one row for each unit and part of the error."""
    import pandas as pd

    rows, seeds = [], tuple(seeds)
    for names in cases():
        rows += case(*names, seeds)
        if report is not None:
            report(", ".join(names))
    return pd.DataFrame(rows)


def summary(table: "DataFrame") -> "DataFrame":
    """Root mean squares over the seeds, index ``grade, stand, method, part``, with the share ``refused`` of units that
    show no heading at rest, which count in no mean. The relative standard deviation of a root mean square of n seeds is
    ``1 / sqrt(2 n)``."""
    keys = ["grade", "stand", "method", "part"]
    groups = (table.drop(columns=["seed", "known_bias", "known_scale"]).set_index(keys) ** 2).groupby(
        level=keys, sort=False
    )
    return (groups.mean() ** 0.5).assign(refused=groups["rest"].apply(lambda values: values.isna().mean()))


def _nothing(left: ErrorsLeft) -> ErrorsLeft:
    still = left.only("asymmetry")
    return replace(still, asymmetry=np.zeros(3))


if __name__ == "__main__":
    runs(range(SEEDS), report=lambda text: print(text, flush=True)).to_csv(
        sys.argv[1], index=False, float_format="%.6g"
    )
