"""What later measurements say of earlier times: the fixed-interval smoother over the filter with the Earth's axis.

References
----------
.. [1] H. E. Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic systems,
   AIAA Journal 3 (1965), 1445-1450.
"""

import numpy as np
from numpy.typing import NDArray

from fogkit.gyrocompass.covariance import Noise, Prior
from fogkit.gyrocompass.filters.records import Fixes, Recording
from fogkit.gyrocompass.filters.wander import _run
from fogkit.gyrocompass.filters.wander_estimates import WanderRun, wander_result
from fogkit.gyrocompass.mechanisation import CompassState
from fogkit.rotation import dcm_from_rotvec

Array = NDArray[np.float64]


def smooth_wander(
    recording: Recording,
    fixes: Fixes,
    noise: Noise,
    start: CompassState,
    prior: Prior | None = None,
    *,
    heading_known: bool = True,
    output_interval: float = 1.0,
    course_follows_heading: bool = False,
) -> tuple[WanderRun, WanderRun]:
    """Estimates from all measurements at every time, after a run of the filter.

    Parameters
    ----------
    recording, fixes, noise, start, prior, heading_known, output_interval, course_follows_heading
        As for `fogkit.gyrocompass.filters.wander.run_wander`; all measurements must be at times of the output.

    Returns
    -------
    filtered, smoothed : WanderRun
        At the end both are the same.

    Notes
    -----
    Between two rows k and k+1 the filter moves its state, and corrects it there by x. What is still wrong of the state
    at k after its own correction is, from later measurements, ``C (x_{k+1} + d_{k+1})`` with
    ``C = P_k Phi^T (P_{k+1}^-)^{-1}``, ``d`` being the same at k+1: the smoother of [1]_ for errors that are fed back.
    """
    filtered, (transitions, before, corrections) = _run(
        recording, fixes, noise, start, prior, heading_known, output_interval, course_follows_heading, smooth=True
    )
    P = filtered.wander_covariance
    smoothed, d = P.copy(), np.zeros((len(P), P.shape[1]))
    for k in range(len(P) - 2, -1, -1):
        gain = _divided(P[k] @ transitions[k].T, before[k])
        d[k] = gain @ (corrections[k + 1] + d[k + 1])
        smoothed[k] = P[k] + gain @ (smoothed[k + 1] - before[k]) @ gain.T
        smoothed[k] = 0.5 * (smoothed[k] + smoothed[k].T)
    state = filtered.state.copy()
    state[:, :8] -= d[:, 3:11]
    state[:, 8:] += d[:, 11:]
    attitude = dcm_from_rotvec(-d[:, :3]) @ filtered.C_h_w
    innovations = filtered.fix_time, filtered.nis, filtered.fix_count
    return filtered, wander_result(filtered.time, attitude, state, smoothed, innovations)


def _divided(left: Array, P: Array) -> Array:
    """``left @ inv(P)``, with the states brought to one size first."""
    scale = np.sqrt(np.diag(P))
    scale[scale == 0] = 1.0
    return np.linalg.lstsq(P / np.outer(scale, scale), (left / scale).T, rcond=1e-14)[0].T / scale
