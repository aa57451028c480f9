"""Temperature: a thermal network, models of its effect on a gyro, and which of them the data support.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`network`           which temperatures have the parts while the chamber does its programme?
`rates`             how fast do noisy temperatures change?
`experiment`        what do gyro and thermometers read in a temperature test?
`models`            which temperatures and rates may the bias depend on?
`regression`        what are the coefficients, and how well are they known?
`selection`         which measuring points count, and what can the data not separate?
==================  =====================================================================================
"""

from fogkit.thermal.models import TemperatureModel, Term
from fogkit.thermal.network import Profile, ThermalNetwork
from fogkit.thermal.regression import TemperatureFit, fit
from fogkit.thermal.selection import cross_validate, prune, separability

__all__ = [
    "Profile",
    "TemperatureFit",
    "TemperatureModel",
    "Term",
    "ThermalNetwork",
    "cross_validate",
    "fit",
    "prune",
    "separability",
]
