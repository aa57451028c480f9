"""Le Van Chang (2015), gyrocompass on a rocked mount: printed inputs, equations derived, rates and requirements.

The text is a scan with garbled formulas: `derivation` has them as restored, beside what follows by derivation.
"""

from fogkit.reproduction.lechang import (
    derivation,
    experiment_verdicts,
    experiments,
    filtering,
    paper,
    pyramid,
    rates,
    requirements,
    scanning,
    simulation,
)

__all__ = [
    "derivation",
    "experiment_verdicts",
    "experiments",
    "filtering",
    "paper",
    "pyramid",
    "rates",
    "requirements",
    "scanning",
    "simulation",
]
