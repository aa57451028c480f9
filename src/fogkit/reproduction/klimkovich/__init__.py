"""B. V. Klimkovich (2022), calibration of a strapdown system on a rough turntable: printed inputs, plan of its tests.

The paper's figure 1, which shows where the nine tests start and how they turn, is lost; `plan_search` recovers it from
the matrix of the appendix, by the first-order model of `fogkit.calibration.navigation_based.turn_model`.
"""

from fogkit.reproduction.klimkovich import paper, plan_search

__all__ = ["paper", "plan_search"]
