"""``drift``: what does angular acceleration do to a closed-loop gyro?"""

from argparse import Namespace

import numpy as np

from fogkit.cli.files import versions
from fogkit.cli.results import Result
from fogkit.io.verdicts import Finding
from fogkit.optics import drift as laws
from fogkit.optics.coil import Coil
from fogkit.optics.gyro import ClosedLoopGyro
from fogkit.optics.loop import Loop
from fogkit.units import DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, MICROMETRE, MICROSECOND


def drift(args: Namespace) -> Result:
    """Drift under harmonic and constant angular acceleration, to second degree; and of the exact response."""
    gyro = ClosedLoopGyro(
        coil=Coil(length=args.length, diameter=args.diameter, wavelength=args.wavelength * MICROMETRE),
        loop=Loop(
            depth=args.depth * np.pi,
            half_period=args.half_period * MICROSECOND,
            half_periods=args.half_periods,
            gain=args.gain,
        ),
    )
    acceleration = np.array(sorted(args.acceleration)) * DEG_PER_SECOND_SQUARED
    shaken = laws.vibration_drift(gyro, acceleration, args.frequency)
    steady = laws.steady_drift(gyro, acceleration)
    exact = laws.full_response_drift(gyro, acceleration)
    departure = float(np.abs(steady / exact - 1).max())
    severity = "good" if departure < 0.01 else "doubtful"
    text = f"second degree and exact response differ by {departure:.2g} at most, under constant acceleration"
    names = ("length", "diameter", "wavelength", "depth", "half_period", "half_periods", "gain", "frequency")
    return Result(
        command="drift",
        findings=[Finding(check="degree", severity=severity, text=text)],
        parameters={name: getattr(args, name) for name in names},
        versions=versions(),
        tables={
            "drift": {
                "acceleration_deg_s2": acceleration / DEG_PER_SECOND_SQUARED,
                "oscillation_dph": shaken / DEG_PER_HOUR,
                "constant_dph": steady / DEG_PER_HOUR,
                "exact_constant_dph": exact / DEG_PER_HOUR,
            }
        },
    )
