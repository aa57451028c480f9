"""Which Euler sequence the pyramid's printed angles belong to: the thesis names the angles, not the axes.

Equation (13) says what the gyros stand like: gyro y has ``1/sqrt(3)`` of a rate about the mount's axis and
``sqrt(2/3)`` of one about its forward axis, and no part of one to starboard.
"""

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.reproduction.lechang.paper import PYRAMID_ANGLES_DEG
from fogkit.units import DEG

if TYPE_CHECKING:
    from pandas import DataFrame

ROUNDING = 1e-3
"""Entries of a matrix of angles that are rounded to 0.1 degree: half of that, in rad, is 9e-4."""


def sequences() -> "DataFrame":
    """The twelve Euler sequences with either sense of the second and third turn, at the printed angles.

    Returns
    -------
    DataFrame
        Columns ``sequence``, ``signs``, ``even`` (all gyros as steep to the mount's axis), ``upward`` (and all on its
        upper side), ``equation_13`` (gyro y as (13) has it). All are orthogonal, as any sequence is. A half turn is
        the same in either sense, so the first has one.
    """
    import pandas as pd

    rows = []
    for sequence in map("".join, product("XYZ", repeat=3)):
        if sequence[0] == sequence[1] or sequence[1] == sequence[2]:
            continue
        for signs in product((1, -1), repeat=2):
            C = pyramid_axes(np.array(PYRAMID_ANGLES_DEG) * DEG * (1, *signs), sequence)
            steep = np.abs(np.abs(C[1]) - 3**-0.5).max() < ROUNDING
            rows.append(
                {
                    "sequence": sequence,
                    "signs": "".join("+-"[sign < 0] for sign in (1, *signs)),
                    "even": bool(steep),
                    "upward": bool(steep and (C[1] > 0).all()),
                    "equation_13": bool(np.abs(C[:, 1] - [np.sqrt(2 / 3), 3**-0.5, 0]).max() < ROUNDING),
                }
            )
    return pd.DataFrame(rows)
