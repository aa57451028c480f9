"""Estimation from matrices: what the numbers are, how sure they are, and what the data leave open.

No module here knows what a gyro is.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`leastsquares`      which parameters fit best, linear and nonlinear, with any noise covariance and priors?
`solution`          the record that comes back: estimate, covariance, chi-square, unobservable directions
`consistency`       are the predicted standard deviations true over many runs?
==================  =====================================================================================
"""

from fogkit.estimation.leastsquares import linear, nonlinear
from fogkit.estimation.solution import Solution

__all__ = ["Solution", "linear", "nonlinear"]
