"""Le Van Chang (2015), gyrocompass on a rocked mount: printed inputs, equations derived, rates and requirements.

The text is a scan with garbled formulas: `derivation` has them as restored, beside what follows by derivation.
"""

from fogkit.reproduction.lechang import (
    derivation,
    differences,
    filtering,
    kinematics,
    paper,
    pyramid,
    rates,
    requirements,
    simulation,
    simulation_claims,
    simulation_runs,
)

__all__ = [
    "derivation",
    "differences",
    "filtering",
    "kinematics",
    "paper",
    "pyramid",
    "rates",
    "requirements",
    "simulation",
    "simulation_claims",
    "simulation_runs",
]
