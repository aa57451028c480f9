"""Many runs of anything: one function over many cases, on any executor, in memory or stored as they come.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`mapping`           what does a function give for each of some cases, here and now?
`designs`           which cases: a grid, or points spread over ranges and distributions?
`runs`              the same as a campaign that outlives a crash: stored, resumed, failures kept, seeded
`cases`             which arguments has each case, and can the function be called with them?
`attempts`          what does one run give, in the worker: outputs, or what went wrong?
`identity`          which case is it, and which random stream is its own?
`store`             what stands on the disk, and does it belong to what is asked?
==================  =====================================================================================
"""

from fogkit.campaign.designs import grid, spread
from fogkit.campaign.identity import case_generator
from fogkit.campaign.mapping import map_cases
from fogkit.campaign.runs import run_campaign
from fogkit.campaign.store import CampaignMismatchError, read_campaign

__all__ = [
    "CampaignMismatchError",
    "case_generator",
    "grid",
    "map_cases",
    "read_campaign",
    "run_campaign",
    "spread",
]
