"""What a law of the mount does for heading: mean direction, observability, coloured noise, encoder, history.

Each function answers one question in one table; `law_map` has the sweep over amplitude and period. Inputs are those of
the thesis's experiment unless an argument says otherwise.
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.accuracy import (
    best_harmonic_amplitude,
    encoder_share,
    heading_bound,
    steady_heading_std,
)
from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.encoder import Encoder, UnsteadyLaw
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.laws import (
    ConstantSpeedReversal,
    DwellAndTurn,
    Fixed,
    MountLaw,
    OneWay,
    QuasiHarmonic,
    SwitchedOn,
)
from fogkit.gyrocompass.observability import Observability, directions_seen
from fogkit.noise import RandomErrors
from fogkit.reproduction.lechang import law_map, paper, simulation
from fogkit.units import ARCMIN, DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, MILLISECOND, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

BEST = best_harmonic_amplitude()


def laws(period: float = paper.EXPERIMENT_PERIOD) -> dict[str, MountLaw]:
    """Laws of one period, s, by name; dwell-and-turn spends a sixth of it in its turns."""
    return {
        "off": Fixed(),
        "harmonic, 90 deg": QuasiHarmonic(amplitude=np.pi / 2, period=period),
        "harmonic, 137.8 deg": QuasiHarmonic(amplitude=BEST, period=period),
        "harmonic, 180 deg": QuasiHarmonic(amplitude=np.pi, period=period),
        "harmonic, 360 deg": QuasiHarmonic(amplitude=2 * np.pi, period=period),
        "constant speed, 90 deg": ConstantSpeedReversal(amplitude=np.pi / 2, period=period),
        "constant speed, 180 deg": ConstantSpeedReversal(amplitude=np.pi, period=period),
        "two opposite dwells": DwellAndTurn(dwell=5 * period / 12, turn_duration=period / 12),
        "one way": OneWay(period=period),
    }


def bound_table() -> "DataFrame":
    """Bound of heading for the laws, white noise, five minutes: index ``law``.

    Returns
    -------
    DataFrame
        ``mean_direction`` (real part), ``information_lost`` (1), ``std_excess`` (1) over a law that loses nothing, and
        ``heading_arcmin`` of gyros of the VG951's noise.
    """
    import pandas as pd

    rows = {}
    for name, law in laws().items():
        bound = heading_bound(law, paper.EXPERIMENT_TIME, paper.ASSUMED_LATITUDE, law_map.random_walk())
        rows[name] = {
            "mean_direction": bound.mean_direction.real,
            "information_lost": 1 - bound.efficiency,
            "std_excess": bound.efficiency**-0.5 - 1 if bound.efficiency else np.inf,
            "heading_arcmin": bound.std / ARCMIN,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("law")


# ---- observability

OBSERVED_TIME = 400.0
OBSERVED_PRIOR = Prior(heading=10 * DEG, bias=10 * DEG_PER_HOUR, scale_factor=1 * PERCENT, position=1.0, height=1.0)


def seen(on: bool, rolling: bool, axes: Array | None = None, dt: float = 0.1) -> Observability:
    """What 400 s of perfect gyros and an aid of 1 mm/s and 0.1 m see of heading, biases and scale factors.

    Parameters
    ----------
    on, rolling : bool
        Whether the mount is on, with the law of the simulation, and whether the vessel rolls, as there.
    axes : ndarray, shape (3, 3), optional
        Input axes of the gyros in the mount; the pyramid's if not given.
    dt : float, optional
        Step, s.
    """
    motion = simulation.vessel(rolling=rolling).motion(OBSERVED_TIME, dt, simulation.mount() if on else None, axes=axes)
    aid = Aid.satellite(paper.ASSUMED_LATITUDE, velocity=1e-3, position=0.1)
    return directions_seen(motion, aid, OBSERVED_PRIOR, simulation.SEEN)


def observability_table(dt: float = 0.1) -> "DataFrame":
    """Singular values of `seen`, descending, and the rank: off and on, at rest and rolling, pyramid and cube."""
    import pandas as pd

    rows = {}
    for arrangement, axes in (("pyramid", None), ("cube", simulation.CUBE)):
        for on in (False, True):
            for rolling in (False, True):
                found = seen(on, rolling, axes, dt)
                key = (arrangement, "on" if on else "off", "rolling" if rolling else "at rest")
                rows[key] = [found.rank(), *found.singular_values]
    columns = ["rank", *(f"s{k}" for k in range(1, 8))]
    frame = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    frame.index = pd.MultiIndex.from_tuples(frame.index, names=["gyros", "mount", "hull"])
    return frame


# ---- noise that is not white

COLOURED: Mapping[str, RandomErrors] = {
    name: RandomErrors(angle_random_walk=law_map.random_walk(), bias_instability=b, rate_random_walk=k)
    for name, b, k in (
        ("white noise only", 0.0, 0.0),
        ("bias instability 0.5 deg/h", 0.5 * DEG_PER_HOUR, 0.0),
        ("rate random walk 10 deg/h/√h", 0.0, 10 * DEG_PER_HOUR_PER_SQRT_HOUR),
    )
}
"""Gyros of the VG951's white noise with more; the thesis states nothing of bias drift, so these are examples."""


def coloured(amplitude: float, periods: Iterable[float], duration: float = 3000.0) -> "DataFrame":
    """Heading, arcmin, with the noises of `COLOURED` under harmonic laws of an amplitude, rad: index ``period``, s."""
    import pandas as pd

    rows = {}
    for period in periods:
        law = QuasiHarmonic(amplitude=amplitude, period=float(period))
        rows[float(period)] = {
            name: steady_heading_std(law, duration, paper.ASSUMED_LATITUDE, errors.power_spectral_density) / ARCMIN
            for name, errors in COLOURED.items()
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("period")


# ---- encoder and speed

ENCODERS: Mapping[str, Encoder] = {
    "zero wrong by 1'": Encoder(offset=ARCMIN),
    "reading 10 ms old": Encoder(delay=10 * MILLISECOND),
    "play of 2'": Encoder(backlash=2 * ARCMIN),
    "twist at reversals": Encoder(compliance=0.05),
    "1' once a turn": Encoder(harmonic=ARCMIN, phase=np.pi / 2),
    "1' twice a turn": Encoder(harmonic=ARCMIN, order=2, phase=np.pi / 2),
}
"""Twist: 0.05 rad for 1 rad/s^2. The phases of the once-a-turn error are those that the harmonic laws pass most of."""

REVERSAL_TIME = 0.2


def encoder_laws() -> dict[str, MountLaw]:
    """Harmonic and constant-speed laws of one period, the latter with hard reversals of `REVERSAL_TIME`, s."""
    period = paper.EXPERIMENT_PERIOD
    harmonic = {f"harmonic, {a / DEG:.4g} deg": QuasiHarmonic(amplitude=a, period=period) for a in (np.pi / 2, np.pi)}
    hard = {
        f"constant speed, {a / DEG:.4g} deg": ConstantSpeedReversal(
            amplitude=a, period=period, reversal_time=REVERSAL_TIME
        )
        for a in (np.pi / 2, np.pi)
    }
    return harmonic | hard


def encoder_table(duration: float = paper.EXPERIMENT_TIME) -> "DataFrame":
    """Largest error of the sensor and what is left of it in heading, both arcmin: a row per error, a column per law.

    Columns are pairs of the law and ``"sensor"`` or ``"heading"``.
    """
    import pandas as pd

    t = np.linspace(0.0, paper.EXPERIMENT_PERIOD, 6001)
    rows = {
        name: {
            (law_name, column): value / ARCMIN
            for law_name, law in encoder_laws().items()
            for column, value in (
                ("sensor", float(np.abs(encoder.error(law, t)).max())),
                ("heading", abs(encoder_share(law, encoder, duration))),
            )
        }
        for name, encoder in ENCODERS.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("error")


def speed_share(law: MountLaw, gyros: int, repeats: str, fraction: float = 0.05, points: int = 6000) -> float:
    """Error of heading, rad, of the least-squares fit when the mount's speed is unsteady and taken to be steady.

    Parameters
    ----------
    law : MountLaw
        What is commanded; its rate is taken for the true one, the angle is measured.
    gyros : int
        1: the gyro y of (13) alone, with an unknown bias; 3: all.
    repeats : {"angle", "time"}
        Whether the departure comes once a turn, at the same angles there and back, or three times a period whatever
        the angle.
    fraction : float, optional
        Amplitude of the speed's departure over the largest speed.
    points : int, optional
        Readings in five minutes, at rest and level.
    """
    t = paper.EXPERIMENT_TIME * (np.arange(points) + 0.5) / points
    angle, rate, _ = law.motion(t)
    if checks.option("repeats", repeats, ("angle", "time")) == "angle":
        angle, true, _ = UnsteadyLaw(law=law, fraction=fraction, phase=0.4).motion(t)
        wrong = true - rate
    else:
        frequency = 3 * 2 * np.pi / law.period
        wrong = fraction * law.max_rate * np.cos(frequency * t + 0.4)
        angle = angle + fraction * law.max_rate / frequency * np.sin(frequency * t + 0.4)
    level = EARTH_RATE * np.cos(paper.ASSUMED_LATITUDE)
    axes = pyramid_axes()[:, [1, 0, 2][:gyros]]
    slopes = [((a - 1j * c) * -1j * np.exp(1j * (angle - paper.STAND_HEADING))).real for a, _, c in axes.T]
    biases = np.kron(np.eye(gyros), np.ones((points, 1)))
    A = np.column_stack([np.concatenate(slopes), biases])
    errors = np.concatenate([up * wrong for _, up, _ in axes.T])
    return float(np.linalg.lstsq(A, errors)[0][0] / level)


def speed_table() -> "DataFrame":
    """Heading error, deg, of a speed unsteady by 5 per cent and taken for steady: `speed_share` by law and gyros."""
    import pandas as pd

    cases = [(gyros, repeats) for gyros in (1, 3) for repeats in ("angle", "time")]
    rows = {
        name: {case: abs(speed_share(law, *case)) / DEG for case in cases}
        for name, law in (encoder_laws() | {"one way": OneWay(period=paper.EXPERIMENT_PERIOD)}).items()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("law")


# ---- what came before counts

HISTORY_PERIOD = 100.0


def histories(off: float) -> dict[str, MountLaw]:
    """Laws that begin with the mount standing at angle 0 for a time, s, by name; the last goes and stands opposite."""
    amplitudes = {"harmonic, 180 deg": np.pi, "harmonic, 137.8 deg": BEST, "harmonic, 219.5 deg": 3.8317}
    found: dict[str, MountLaw] = {
        name: SwitchedOn(law=QuasiHarmonic(amplitude=amplitude, period=HISTORY_PERIOD), start=off)
        for name, amplitude in amplitudes.items()
    }
    turning = ConstantSpeedReversal(amplitude=np.pi, period=HISTORY_PERIOD, reversal_time=1.0)
    found["constant speed, 180 deg"] = SwitchedOn(law=turning, start=off)
    if off:
        found["half a turn, then stand"] = DwellAndTurn(dwell=off, turn_duration=10.0)
    return found


def history_table(off: float = 400.0, on: float = 200.0) -> "DataFrame":
    """Mean direction over a dwell with the mount off and a time with it on, and what it makes of heading.

    Parameters
    ----------
    off, on : float
        Times, s, multiples of 1 s.

    Returns
    -------
    DataFrame
        Index ``law``; ``mean_direction``: its size over the whole time; ``bound_arcmin``: for white noise and unknown
        biases; ``covariance_arcmin``: the simulation's gyros with biases of 6 deg/h and an aid of 0.01 m/s.
    """
    import pandas as pd

    noise = Noise(angle_random_walk=paper.SIMULATED_RANDOM_WALK)
    aid = Aid.satellite(paper.ASSUMED_LATITUDE, velocity=0.01)
    rows = {}
    for name, law in histories(off).items():
        motion = simulation.vessel(rolling=False).motion(off + on, simulation.STEP, law)
        run = run_covariance(motion, noise, aid, simulation.ASSUMED_PRIOR)
        bound = heading_bound(law, off + on, paper.ASSUMED_LATITUDE, paper.SIMULATED_RANDOM_WALK)
        rows[name] = {
            "mean_direction": abs(bound.mean_direction),
            "bound_arcmin": bound.std / ARCMIN,
            "covariance_arcmin": run.of("heading")[-1] / ARCMIN,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("law")
