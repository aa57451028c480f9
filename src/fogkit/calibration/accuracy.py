"""What duration, turns and noise buy: errors of a scale factor and of an axis from whole turns, in closed form."""

from dataclasses import dataclass

import numpy as np

from fogkit import checks


def angle_random_walk_from_density(density: float, *, sided: str, per: str) -> float:
    """Angle random walk of white rate noise whose spectral density is stated in one of the four usual ways.

    Parameters
    ----------
    density : float
        Square root of the spectral density of the rate, rad/s per square root of the frequency unit.
    sided : {"one", "two"}
        Whether the density covers positive frequencies only, or both signs.
    per : {"hertz", "radian"}
        Whether it is per Hz, or per rad/s of angular frequency.

    Returns
    -------
    float
        Angle random walk N, rad/sqrt(s): the angle after a time T has the variance ``N**2 T``.

    Raises
    ------
    ValueError
        If an option is unknown or `density` negative.

    Examples
    --------
    >>> angle_random_walk_from_density(1.0, sided="two", per="hertz")
    1.0
    """
    density = checks.non_negative("density", density)
    sided = checks.option("sided", sided, ("one", "two"))
    per = checks.option("per", per, ("hertz", "radian"))
    # N**2 is the two-sided density per Hz
    factor = (0.5 if sided == "one" else 1.0) * (2 * np.pi if per == "radian" else 1.0)
    return float(density * np.sqrt(factor))


@dataclass(frozen=True, kw_only=True)
class TurnBudget:
    """Relative error of a scale factor from turning once through a large angle, by contributions.

    Attributes
    ----------
    readout : float
        Of the angle readout at both ends (volynskii eq. (21)).
    bias : float
        Of the bias.
    noise : float
        Of the angle random walk.
    """

    readout: float
    bias: float
    noise: float

    @property
    def total(self) -> float:
        """Root of the sum of squares: the contributions are independent."""
        return float(np.sqrt(self.readout**2 + self.bias**2 + self.noise**2))


def scale_factor_budget(
    angle: float, duration: float, *, readout_noise: float, bias_deviation: float, angle_random_walk: float
) -> TurnBudget:
    """Error of the scale factor that one turn determines, relative.

    Parameters
    ----------
    angle : float
        Angle turned, rad.
    duration : float
        Duration, s.
    readout_noise : float
        Standard deviation of one reading of the table angle, rad.
    bias_deviation : float
        Standard deviation of the bias, rad/s.
    angle_random_walk : float
        Of the gyro, rad/sqrt(s).

    Returns
    -------
    TurnBudget
        Contributions (volynskii eq. (22), with both readings of the angle and added as independent).

    Raises
    ------
    ValueError
        If the angle or the duration is not positive, or a deviation negative.
    """
    angle = checks.positive("angle", angle, "rad")
    duration = checks.positive("duration", duration, "s")
    return TurnBudget(
        readout=np.sqrt(2) * checks.non_negative("readout_noise", readout_noise, "rad") / angle,
        bias=checks.non_negative("bias_deviation", bias_deviation, "rad/s") * duration / angle,
        noise=checks.non_negative("angle_random_walk", angle_random_walk, "rad/sqrt(s)")
        * float(np.sqrt(duration))
        / angle,
    )


def direction_error(budget: TurnBudget, cosine: float) -> float:
    """Standard deviation of a direction cosine of a gyro about another's axis, rad, from one turn.

    Parameters
    ----------
    budget : TurnBudget
        Contributions for the turn; the gyro's scale factor is taken to have been found with the same ones.
    cosine : float
        The direction cosine itself: it weights the error of the scale factor and of the angle (volynskii eq. (23)).
    """
    own = np.hypot(budget.bias, budget.noise)
    return float(np.sqrt(own**2 + (cosine * budget.total) ** 2 + (cosine * budget.readout) ** 2))
