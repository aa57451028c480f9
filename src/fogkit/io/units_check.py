"""Are the units those of the description? Gravity and the Earth's rotation tell, and the rates of the plan.

A unit at rest feels gravity, and turns with the Earth. What it reads instead, over what it should, is a factor; one
that is the ratio of two units, or a sampling time, names the mistake. For gyros the test is limited by their drift: one
of 60 times the Earth rate looks like degrees taken for radians, and the text says both.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.constants import EARTH_RATE, STANDARD_GRAVITY
from fogkit.earth import earth_rate_n, normal_gravity
from fogkit.io.description import QUANTITIES, RecordingDescription
from fogkit.io.recordings import Recording
from fogkit.io.segmentation import SIGNED_PERMUTATIONS, Segmentation, segment
from fogkit.io.unit_names import UNITS, si_factor
from fogkit.io.verdicts import Finding, Verdict
from fogkit.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from collections.abc import Iterable

Array = NDArray[np.float64]

GRAVITY_FINE, GRAVITY_OFF = 0.02, 0.10
"""Departure from gravity, relative, that uncalibrated accelerometers may have, and that no sound ones have."""

EARTH_FINE = 3.0
"""Ratio to the Earth rate, or its inverse, within which the unit of a gyro is believed."""

EARTH_MATCH = 1.5
"""Factor by which a ratio may differ from that of a mistake, for gyros at rest."""

IDENTITY = next(i for i, P in enumerate(SIGNED_PERMUTATIONS) if np.array_equal(P, np.eye(3)))

RATE_MATCH = 1.1
"""The same where a planned rate, or gravity, is the reference."""


def check_units(recording: Recording, segmentation: Segmentation | None = None) -> Verdict:
    """What gravity, the Earth's rotation and the plan say of the units.

    Parameters
    ----------
    recording : Recording
        The recording.
    segmentation : Segmentation, optional
        Its dwells and turns, if they are known already.

    Returns
    -------
    Verdict
        One finding for gyros, one for accelerometers if there are; `Finding.factor` is what was read over what there
        is.

    Raises
    ------
    RecordingError
        As `fogkit.io.segment`.
    """
    checks.instance("recording", recording, Recording)
    segmentation = segment(recording) if segmentation is None else segmentation
    return Verdict(unit_findings(recording.description, segmentation))


def unit_findings(description: RecordingDescription, segmentation: Segmentation) -> list[Finding]:
    """Findings on the units, from dwells and turns."""
    windows = segmentation.windows
    runs = [(s.rate, s.force, s.duration) for s in segmentation.segments if s.kind == "dwell"]
    if not runs:  # nothing rests, perhaps because of the units: the slowest tenth has to do
        size = np.linalg.norm(windows.means[:, :3], axis=1)
        slow = np.argsort(size)[: max(1, len(size) // 10)]
        means = windows.means[slow]
        runs = [(m[:3], m[3:6] if description.accel else None, windows.duration) for m in means]
    findings = [_gyros(description, segmentation, runs), *_earth_axes(description, segmentation)]
    return [*findings, _accelerometers(description, runs, windows.dt)] if description.accel else findings


def _accelerometers(description: RecordingDescription, runs: list, dt: float) -> Finding:
    """Size of the specific force against gravity."""
    gravity = description.gravity
    if gravity is None:
        gravity = STANDARD_GRAVITY if description.latitude is None else float(normal_gravity(description.latitude))
    forces = np.array([force for _, force, _ in runs])
    ratio = float(np.median(np.linalg.norm(forces, axis=1))) / gravity
    text = f"accelerometers at rest read {ratio:.4g} times gravity"
    off = abs(ratio - 1)
    if off <= GRAVITY_FINE:
        return Finding(check="units", severity="good", text=text, channel="accel", factor=ratio)
    guess = _guess(description, "accel", ratio, dt, RATE_MATCH) if off > GRAVITY_OFF else ""
    severity = "bad" if off > GRAVITY_OFF else "doubtful"
    return Finding(check="units", severity=severity, text=text + guess, channel="accel", factor=ratio)


def _gyros(description: RecordingDescription, segmentation: Segmentation, runs: list) -> Finding:
    """Rates of the plan, where there are, or the rate at rest against the Earth's."""
    dt = segmentation.windows.dt
    planned = segmentation.verdict.of("rates")
    if planned and planned[0].factor is not None:
        ratio = planned[0].factor
        if 1 / RATE_MATCH < ratio < RATE_MATCH:
            text = f"gyros read {ratio:.4g} times the rates of the plan"
            return Finding(check="units", severity="good", text=text, channel="gyro", factor=ratio)
        text = f"gyros read {ratio:.4g} times the rates of the plan" + _guess(
            description, "gyro", ratio, dt, RATE_MATCH
        )
        return Finding(check="units", severity="bad", text=text, channel="gyro", factor=ratio)
    rates = np.array([rate for rate, *_ in runs])
    weights = np.array([duration for *_, duration in runs])
    noise = _noise(segmentation.windows.means[:, :3], segmentation.windows.duration) / np.sqrt(np.median(weights))
    size = float(np.median(np.linalg.norm(rates, axis=1)))
    ratio = size / EARTH_RATE
    text = f"gyros at rest read {ratio:.4g} times the Earth rate"
    if noise > 0.5 * EARTH_RATE:
        told = f"{text}, and their noise hides it: the unit cannot be checked by the Earth rate"
        told += _guess(description, "gyro", ratio, dt, EARTH_MATCH, ", unless it was ")
        return Finding(check="units", severity="doubtful", text=told, channel="gyro", factor=ratio)
    if 1 / EARTH_FINE < ratio < EARTH_FINE:
        return Finding(check="units", severity="good", text=text, channel="gyro", factor=ratio)
    drift = f": a drift of {size / DEG_PER_HOUR:.3g} deg/h, which hides the unit" if ratio > 1 else ""
    guess = _guess(description, "gyro", ratio, dt, EARTH_MATCH, ", or " if drift else ": looks like ")
    severity = "doubtful" if ratio > 1 else "bad"
    if ratio < 1 and not guess:
        drift = ": what rests on the Earth turns with it"
    return Finding(check="units", severity=severity, text=text + drift + guess, channel="gyro", factor=ratio)


def _earth_axes(description: RecordingDescription, segmentation: Segmentation) -> list[Finding]:
    """Whether the Earth's rotation is seen by the axes that the plan says, from dwell to dwell: free of biases."""
    planned = {step.label: step for step in segmentation.steps if step.C_b_n is not None and not step.turns}
    pairs = [(s, planned[s.label]) for s in segmentation.segments if s.label in planned and s.kind == "dwell"]
    if len(pairs) < 3 or description.latitude is None:
        return []
    read = np.array([s.rate for s, _ in pairs])
    read = read - read.mean(axis=0)
    C = np.array([step.C_b_n for _, step in pairs]).reshape(-1, 3, 3)
    noise = _noise(segmentation.windows.means[:, :3], segmentation.windows.duration)
    noise /= np.sqrt(np.median([s.duration for s, _ in pairs]))
    headings = [0.0] if all(step.north for _, step in pairs) else np.arange(72) * (2 * np.pi / 72)
    fits = np.array([_misfits(read, C, description.latitude, heading) for heading in headings]).min(axis=0)
    best, named = float(fits.min()), float(fits[IDENTITY])
    seen = float(np.sqrt(np.mean(read**2)))
    if seen < 3 * noise or best > 0.3 * seen:
        return []  # drift or noise hides it, with any axes
    if named < 2 * best + 0.1 * seen:
        return [
            Finding(check="axes", severity="good", text="the Earth turns about the axes of the plan", channel="gyro")
        ]
    P = SIGNED_PERMUTATIONS[int(fits.argmin())]
    names = [("-" if row.sum() < 0 else "") + "xyz"[int(np.argmax(np.abs(row)))] for row in P]
    text = f"the Earth's rotation fits the plan if its x, y, z are recorded as {', '.join(names)}, and not as they are"
    return [Finding(check="axes", severity="doubtful", text=text, channel="gyro")]


def _misfits(read: Array, C_b_n: Array, latitude: float, heading: float) -> Array:
    """Root mean square of readings less the Earth's rotation, rad/s, with each order and sign of the axes."""
    east, north, up = earth_rate_n(latitude)
    earth = np.array([north * np.sin(heading) + east, north * np.cos(heading), up])
    expected = np.einsum("nji,j->ni", C_b_n, earth)
    expected = expected - expected.mean(axis=0)
    return np.array([np.sqrt(np.mean((read @ P.T - expected) ** 2)) for P in SIGNED_PERMUTATIONS])


def _noise(means: Array, duration: float) -> float:
    """Density of the white noise of the worst gyro, rad/sqrt(s), from its windows."""
    steps = np.abs(np.diff(means, axis=0))
    return float(np.median(steps, axis=0).max()) / 0.6745 / np.sqrt(2) * np.sqrt(duration)


def mistakes(description: RecordingDescription, sensor: str, dt: float) -> "Iterable[tuple[float, str]]":
    """Ratio of what is read to what there is, for each other unit or quantity that the file may really hold.

    Parameters
    ----------
    description : RecordingDescription
        What it is believed to hold.
    sensor : {"gyro", "accel"}
        Which sensors.
    dt : float
        Sampling time, s.

    Yields
    ------
    ratio : float
        Factor that readings are too large by.
    text : str
        The mistake: ``"deg/s taken for rad/s"``.
    """
    channels = getattr(description, sensor)
    taken = channels.factor(sensor, dt)
    for quantity, kind in zip(("rates", "increments"), QUANTITIES[sensor], strict=True):
        for unit in UNITS[kind]:
            if (unit, quantity) != (channels.unit, channels.quantity):
                real = channels.scale * si_factor(kind, unit) / (dt if quantity == "increments" else 1.0)
                words = f"{unit} taken for {channels.unit}"
                if quantity != channels.quantity:
                    words = f"{quantity} ({unit}) taken for {channels.quantity} ({channels.unit})"
                    words += f" at {1 / dt:.5g} Hz"
                yield taken / real, words


def _guess(
    description: RecordingDescription,
    sensor: str,
    ratio: float,
    dt: float,
    match: float,
    before: str = ": looks like ",
) -> str:
    """The mistakes whose factor is nearest to the one found, in words; nothing if none is near."""
    if not ratio > 0 or not np.isfinite(ratio):
        return ""
    found = sorted((abs(np.log(ratio / factor)), factor, words) for factor, words in mistakes(description, sensor, dt))
    near = [(factor, words) for distance, factor, words in found if distance < min(np.log(match), found[0][0] + 1e-3)]
    if not near:
        return ""
    factor = near[0][0]
    return f"{before}{' or '.join(words for _, words in near[:3])}, a factor of {factor:.4g}"
