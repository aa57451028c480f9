"""Calibration of fibre-optic gyroscopes (FOGs): their physics, their error laws, and the papers behind them.

Conventions, without exception
------------------------------
Units
    SI and radians, latitude and heading included. A name carries a unit only where it is not SI (``heading_deg``), at
    the edges. Convert by multiplying: ``0.01 * DEG_PER_HOUR`` (`fogkit.units`).
Frames
    i (inertial), e (Earth), n (navigation: east, north, up), b (body, right-handed: x right, y forward, z up).
    ``C_b_n`` takes body components to navigation ones, ``v_n = C_b_n @ v_b``; ``omega_ie_n`` is the rate of e against
    i in axes of n. Heading is clockwise from north.
Arrays
    Time first: ``(n,)``, ``(n, 3)``, ``(n, 3, 3)``; functions broadcast over leading axes.
Tables
    pandas, index ``time`` in s. Readings of an inertial measurement unit have the columns ``gyro_x, gyro_y, gyro_z``,
    rad/s, ``accel_x, accel_y, accel_z``, m/s^2, and ``temperature_*``, degC.
Spectra
    A white rate noise of angle random walk N, rad/sqrt(s), has the two-sided power spectral density ``N**2``.
Randomness
    A ``numpy.random.Generator`` that is passed in.
Errors
    Bad input is a ``ValueError`` or ``TypeError`` that names the argument, what was needed and what came; a legal but
    doubtful one is a ``UserWarning`` with the number.

Modules, each importing only from those above it
------------------------------------------------
======================  ==============================================================================================
`fogkit.constants`      speed of light, WGS 84
`fogkit.units`          conversion factors
`fogkit.checks`         checks of arguments, and the wording of errors
`fogkit.results`        what every result can do: table, text and back
`fogkit.rotation`       direction-cosine matrices, angles, small-angle errors
`fogkit.earth`          radii, normal gravity, Earth and transport rate
`fogkit.estimation`     least squares with priors, covariance and what the data leave open; consistency of filters
`fogkit.noise`          random errors: angle random walk to rate ramp, Allan deviation, identification
`fogkit.optics`         one gyro: coil, interferometer, digital loop, simulator, drift under vibration and its remedies
`fogkit.thermal`        temperature: thermal network, models of its effect, which of them the data support
`fogkit.imu`            three axes: error model, constructions, a whole unit with delays and size effect
`fogkit.stand`          rate table, plate and rough turntable with their errors, plans, what is read meanwhile
`fogkit.navigation`     strapdown mechanisation: attitude and velocity from increments
`fogkit.calibration`    requirements, three stages, many positions, rate sequences, by navigation; uncertainty, plans
`fogkit.gyrocompass`    gyrocompass on a rocked mount: equations, laws, accuracy, filters, scan of the Earth rate
`fogkit.instrument`     one whole unit through every calibration to heading: what is left of each error
`fogkit.campaign`       many runs of anything, on any executor
`fogkit.claims`         the ledger of claims: what the papers state, and what became of it
`fogkit.reproduction`   the papers: instruments, derivations, figures, values of the ledger
`fogkit.io`             recordings of users: read, judged, segmented, reduced, written
`fogkit.plotting`       figures
`fogkit.cli`            the command line ``fogkit``: results as JSON, reports as one page
======================  ==============================================================================================

``import fogkit`` loads nothing of these: each is loaded when it is first used, and loads what it needs.
"""

import importlib

__version__ = "0.1.0"

_MODULES = {
    *("calibration", "campaign", "checks", "claims", "cli", "constants", "earth", "estimation", "gyrocompass", "imu"),
    *("instrument", "io", "navigation", "noise", "optics", "plotting", "reproduction", "results", "rotation"),
    *("stand", "thermal", "units"),
}


def __getattr__(name: str):
    if name in _MODULES:
        return importlib.import_module(f"fogkit.{name}")
    raise AttributeError(f"module 'fogkit' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
