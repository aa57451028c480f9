"""Three qualities of a table as examples, each in the three shapes that the methods ask for.

One description serves the three-axis table of the three stages, plate and single-axis table of positions and rates, and
the rough turntable of the calibration by navigation. The numbers are chosen here and taken from no paper.
"""

from dataclasses import dataclass

import numpy as np

from fogkit import checks
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.table import RateTable
from fogkit.units import ARCSEC, DEG, DEG_PER_SECOND_SQUARED, PPM


@dataclass(frozen=True, kw_only=True)
class Stand:
    """A table: standard deviations of its errors, and how it shakes.

    Parameters
    ----------
    name : str
        Of the stand.
    base : float, optional
        Level and azimuth of the base, rad.
    angles : float, optional
        Every other angle: of axes against each other, faces, mounting, and placing anew, rad.
    readout : float, optional
        One reading of the table's angle, and the angle of a turn, rad.
    rate : float, optional
        Commanded rates, relative.
    roughness : float, optional
        Of `fogkit.stand.rough_table.RoughTable.typical`, for wobble and the like.
    acceleration : float, optional
        Amplitude of the angular acceleration by which it shakes what stands on it, about each axis, rad/s^2.

    Raises
    ------
    ValueError
        If a number is negative or not finite.
    """

    name: str
    base: float = 0.0
    angles: float = 0.0
    readout: float = 0.0
    rate: float = 0.0
    roughness: float = 0.0
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        for name in ("base", "angles", "readout", "rate", "roughness", "acceleration"):
            object.__setattr__(self, name, checks.non_negative(name, getattr(self, name)))

    def rate_table(self, latitude: float, rng: np.random.Generator) -> RateTable:
        """One three-axis table of the kind; `latitude` in rad."""
        base, angles = self.base * rng.standard_normal(3), self.angles * rng.standard_normal(5)
        return RateTable(
            latitude=latitude,
            level_east=base[0],
            level_north=base[1],
            azimuth_error=base[2],
            outer_middle=angles[0],
            middle_inner=angles[1],
            mounting=angles[2:],
            readout_noise=self.readout,
            rate_stability=self.rate,
        )

    def laboratory(self, latitude: float, rng: np.random.Generator) -> Laboratory:
        """One plate and single-axis table of the kind; `latitude` in rad."""
        base, faces = self.base * rng.standard_normal(3), self.angles * rng.standard_normal((6, 3))
        return Laboratory(
            latitude=latitude,
            level_east=base[0],
            level_north=base[1],
            azimuth_error=base[2],
            faces=faces,
            mounting=self.angles * rng.standard_normal(3),
            placement_error=self.angles,
            turn_error=self.readout,
            rate_error=self.rate,
        )

    def rough_table(self, latitude: float) -> RoughTable:
        """The turntable of two axes; `latitude` in rad. What it draws, it draws in each test."""
        return RoughTable.typical(latitude, self.roughness)


IDEAL = Stand(name="ideal")
FINE = Stand(
    name="fine", base=5 * ARCSEC, angles=5 * ARCSEC, readout=1 * ARCSEC, rate=5 * PPM, roughness=0.01,
    acceleration=50 * DEG_PER_SECOND_SQUARED,
)  # fmt: skip
ROUGH = Stand(
    name="rough", base=0.1 * DEG, angles=0.1 * DEG, readout=0.02 * DEG, rate=1000 * PPM, roughness=1.0,
    acceleration=1000 * DEG_PER_SECOND_SQUARED,
)  # fmt: skip

STANDS = {stand.name: stand for stand in (IDEAL, FINE, ROUGH)}
"""The examples: without errors, as a laboratory buys them, and good to a tenth of a degree."""
