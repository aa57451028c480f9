"""The bench: a three-axis rate table with its errors, what the operator does with it, and what comes out.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`table`             where is the platform, and which errors does it have?
`plans`             which positions and turns, for how long?
`bench`             what do gyros and table read while a plan is carried out?
==================  =====================================================================================
"""

from fogkit.stand.bench import BenchRecord
from fogkit.stand.plans import Plan, Segment
from fogkit.stand.table import RateTable

__all__ = ["BenchRecord", "Plan", "RateTable", "Segment"]
