"""Random errors of inertial sensors: make them, read them, name them (IEEE 952).

==================  =====================================================================================
module              answers
==================  =====================================================================================
`processes`         which random errors are there, what do they look like, and how are records of them made?
`increments`        how are second differences of the angle correlated, in closed form?
`covariance`        how far off is an Allan variance by chance, and together with which others?
`allan`             what is the Allan deviation of a record, with its error bars?
`identification`    which random errors does a record show, how large, and how sure is that?
==================  =====================================================================================
"""

from fogkit.noise.allan import AllanDeviation, allan_deviation
from fogkit.noise.covariance import allan_covariance, equivalent_degrees_of_freedom, mean_covariance
from fogkit.noise.identification import Identification, identify, predict
from fogkit.noise.processes import PROCESSES, RandomErrors, quantize, simulate

__all__ = [
    "PROCESSES",
    "AllanDeviation",
    "Identification",
    "RandomErrors",
    "allan_covariance",
    "allan_deviation",
    "equivalent_degrees_of_freedom",
    "identify",
    "mean_covariance",
    "predict",
    "quantize",
    "simulate",
]
