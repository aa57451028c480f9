"""A temperature test of a whole unit, and the model that it gives for each gyro."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.instrument.description import Conditions, Instrument
from fogkit.thermal.experiment import CoilBias, campaign, start_ups
from fogkit.thermal.models import several_points
from fogkit.thermal.regression import fit
from fogkit.units import HOUR

Array = NDArray[np.float64]

POINTS = ("coil_top", "coil_bottom", "electronics")
"""Thermometers of the model: both faces of the coil and the electronics."""


def temperature_test(
    instrument: Instrument,
    rng: np.random.Generator,
    *,
    points: Sequence[str] = POINTS,
    chambers: Sequence[float] = (-10.0, 10.0, 30.0, 50.0),
    duration: float = 2 * HOUR,
    repeatability: float = 0.0,
) -> tuple[CoilBias, CoilBias, CoilBias]:
    """Effect of temperature on each gyro, as a regression on starts in a chamber finds it.

    Parameters
    ----------
    instrument : Instrument
        Noise of gyros and thermometers is drawn.
    rng : numpy.random.Generator
        Its source.
    points : sequence of str, optional
        Nodes whose temperatures and rates the model has.
    chambers : sequence of float, optional
        Temperatures of the starts, degC.
    duration : float, optional
        Of each, s.
    repeatability : float, optional
        Standard deviation of the biases from start to start, rad/s.

    Returns
    -------
    tuple of CoilBias
        Coefficients of gyros x, y, z; their constants are those of the test and mean nothing elsewhere.
    """
    checks.instance("instrument", instrument, Instrument)
    effects = {
        f"bias_{axis}": _scaled(instrument.thermal, share, instrument.angle_random_walk, repeatability)
        for axis, share in zip("xyz", instrument.thermal_share, strict=True)
    }
    tables = campaign(instrument.network, start_ups(chambers, duration), effects=effects, rng=rng)
    reference = instrument.thermal.reference
    model = several_points(points, reference=reference)
    found = []
    for name in effects:
        result = fit(model, tables, name, warn=False)
        temperature, rate = (
            {term.point: result.coefficient(term.name) for term in model.terms if term.rate == wanted}
            for wanted in (False, True)
        )
        constant = result.coefficient(model.names[0])
        found.append(CoilBias(constant=constant, temperature=temperature, rate=rate, reference=reference))
    return tuple(found)


def modelled_bias(
    instrument: Instrument, models: Sequence[CoilBias], conditions: Conditions, after: ArrayLike = 0.0
) -> Array:
    """What the models of three gyros say of their biases, rad/s, shape (..., 3); true temperatures are taken.

    `conditions` and `after` are those of `Instrument.thermal_bias`.
    """
    biases = [
        replace(instrument, thermal=model, thermal_share=(1.0, 1.0, 1.0)).thermal_bias(conditions, after)[..., axis]
        for axis, model in enumerate(models)
    ]
    return np.stack(biases, axis=-1)


def _scaled(effect: CoilBias, share: float, walk: float, repeatability: float) -> CoilBias:
    temperature, rate = (
        {point: share * value for point, value in part.items()} for part in (effect.temperature, effect.rate)
    )
    return replace(effect, temperature=temperature, rate=rate, angle_random_walk=walk, bias_repeatability=repeatability)
