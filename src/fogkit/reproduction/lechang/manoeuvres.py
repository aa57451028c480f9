"""What a turn of the hull does for heading, beside a turn of the mount: standard deviations by covariance.

A hull that turns shows biases as a mount does: level biases stay with the gyros, the Earth's rate does not. A vessel
that moves while it turns shows more: its acceleration, which the aid measures north and east and the accelerometers
ahead and abeam. How much that is worth, the aid decides.
"""

from typing import TYPE_CHECKING

from fogkit.gyrocompass.covariance import Aid, Noise, Prior, run_covariance
from fogkit.gyrocompass.laws import ConstantSpeedReversal, DwellAndTurn, Fixed, MountLaw, OneWay, QuasiHarmonic
from fogkit.gyrocompass.motions import Vessel
from fogkit.reproduction.lechang import paper
from fogkit.units import DEG, DEG_PER_HOUR, PERCENT

if TYPE_CHECKING:
    from pandas import DataFrame

NO_MEAN = 2.404825557695773
"""First zero of the Bessel function J0, rad: the harmonic amplitude, 137.8 degrees, at which a bias averages out."""

MOUNT_LAWS: dict[str, MountLaw] = {
    "mount fixed": Fixed(),
    "mount rocked by 180 deg": QuasiHarmonic(amplitude=paper.EXPERIMENT_AMPLITUDE, period=paper.EXPERIMENT_PERIOD),
    "mount rocked by 137.8 deg": QuasiHarmonic(amplitude=NO_MEAN, period=paper.EXPERIMENT_PERIOD),
}

HULL_LAWS: dict[str, MountLaw] = {
    "hull: circle in 300 s": OneWay(period=300.0),
    "hull: circle in 100 s": OneWay(period=100.0),
    "hull: zig-zag by 45 deg": ConstantSpeedReversal(amplitude=45 * DEG, period=100.0, reversal_time=10.0),
    "hull: zig-zag by 137.8 deg": QuasiHarmonic(amplitude=NO_MEAN, period=150.0),
    "hull: two opposite headings": DwellAndTurn(dwell=120.0, turn_duration=30.0),
}
"""What heading is more than at the start. The fastest turns 6 degrees a second."""

SPEEDS = (0.0, 5.0)
VELOCITY_STDS = (0.01, 0.1)
DURATION, STEP = 300.0, 0.05
PRIOR = Prior(heading=10 * DEG, level=0.1 * DEG, velocity=0.1, bias=6 * DEG_PER_HOUR, scale_factor=0.5 * PERCENT)
NOISE = Noise(angle_random_walk=paper.random_walk_of_the_data_sheet(2))


def vessel(speed: float, turning: MountLaw | None = None, lat: float = paper.ASSUMED_LATITUDE) -> Vessel:
    """The vessel of the thesis's simulation, which may move and turn."""
    return Vessel(
        lat=lat,
        heading=paper.HEADING,
        trim=paper.TRIM,
        roll=paper.ROLL_MEAN,
        roll_swing=paper.ROLL_SWING,
        roll_period=paper.ROLL_SWING_PERIOD,
        speed=speed,
        turning=turning,
    )


def end_of(speed: float, velocity_std: float, mount: MountLaw | None = None, turning: MountLaw | None = None) -> dict:
    """Standard deviations after `DURATION`: heading, deg, and the largest of the biases, deg/h.

    Parameters
    ----------
    speed : float
        m/s.
    velocity_std : float
        Of the aid's velocity, once a second, m/s; position 3 m.
    mount, turning : MountLaw, optional
        What the mount does, and the hull; nothing if not given.
    """
    motion = vessel(speed, turning).motion(DURATION, STEP, mount)
    aid = Aid.satellite(paper.ASSUMED_LATITUDE, velocity=velocity_std)
    std = run_covariance(motion, NOISE, aid, PRIOR, output_interval=DURATION).std[-1]
    return {"heading_deg": std[0] / DEG, "bias_dph": std[9:12].max() / DEG_PER_HOUR}


def manoeuvre_table() -> "DataFrame":
    """Heading at the end of 300 s by turns of the mount or of the hull.

    Returns
    -------
    DataFrame
        Index: what turns. Columns ``heading_deg`` and ``bias_dph`` over ``speed`` (m/s) and ``velocity_std`` (m/s).
    """
    import pandas as pd

    ways = [(name, {"mount": law}) for name, law in MOUNT_LAWS.items()]
    ways += [(name, {"turning": law}) for name, law in HULL_LAWS.items()]
    rows = [
        {"way": name, "speed": speed, "velocity_std": std, **end_of(speed, std, **laws)}
        for name, laws in ways
        for speed in SPEEDS
        for std in VELOCITY_STDS
    ]
    table = pd.DataFrame(rows).set_index(["way", "speed", "velocity_std"]).unstack(["speed", "velocity_std"])
    return table.loc[[name for name, _ in ways]]
