"""Truth from outside: a certified NIST polynomial, exact rationals, numpy and scipy, and Monte Carlo."""

import warnings

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from fogkit.estimation import linear, nonlinear
from fogkit.estimation.consistency import chi_square_interval, nees, ratio_interval

SEEDS = st.integers(0, 2**32 - 1)

# of the saturation curve that several tests fit
SATURATION_X = np.linspace(80, 760, 14)
SATURATION_Y = 240 * (1 - np.exp(-5.5e-4 * SATURATION_X)) + 0.1 * np.cos(7.0 * np.arange(14))


def saturation(b):
    return SATURATION_Y - b[0] * (1 - np.exp(-b[1] * SATURATION_X))


def saturation_jacobian(b):
    decay = np.exp(-b[1] * SATURATION_X)
    return -np.stack([1 - decay, b[0] * SATURATION_X * decay], axis=1)


def random_problem(rng, count=12, parameters=4):
    """Design, observations and a noise covariance with no structure."""
    root = rng.standard_normal((count, count)) + 3 * np.eye(count)
    return rng.standard_normal((count, parameters)), rng.standard_normal(count), root @ root.T


def test_wampler_1():
    # NIST's generated polynomial: all six coefficients are exactly 1, the residuals zero, the condition number 5e6
    x = np.arange(21.0)
    design = x[:, None] ** np.arange(6)
    fit = linear(design, design.sum(axis=1))
    # the largest observations, 3e6, are rounded to 5e-10, which the constant and the slope take over
    assert_allclose(fit.estimate, np.ones(6), rtol=5e-9)
    assert fit.noise_scale < 1e-8
    assert np.isnan(fit.p_value)  # the scatter set the scale, so it tests nothing


def test_ill_conditioned_design_against_exact_rationals():
    rng = np.random.default_rng(12)
    x, y = [sympy.Rational(int(v)) / 8 for v in range(12)], [sympy.Integer(int(v)) for v in rng.integers(-50, 50, 12)]
    A = sympy.Matrix([[v**j for j in range(6)] for v in x])
    exact = (A.T * A).inv()
    b = exact * A.T * sympy.Matrix(y)
    variance = ((sympy.Matrix(y) - A * b).T * (sympy.Matrix(y) - A * b))[0] / 6
    fit = linear(np.array(A.tolist(), dtype=float), np.array(y, dtype=float))
    # condition of some 1e4 with columns of unit length times rounding; normal equations would have lost 1e-8
    assert_allclose(fit.estimate, [float(v) for v in b], rtol=1e-10)
    assert_allclose(fit.standard_deviation, [float(sympy.sqrt(variance * exact[i, i])) for i in range(6)], rtol=1e-10)


@pytest.mark.parametrize("start", [(500, 1e-4), (250, 5e-4)])
@pytest.mark.parametrize("jacobian", [None, saturation_jacobian])
def test_saturation_curve_as_minpack_has_it(start, jacobian):
    from scipy.optimize import curve_fit

    def curve(x, b1, b2):
        return b1 * (1 - np.exp(-b2 * x))

    other, covariance = curve_fit(curve, SATURATION_X, SATURATION_Y, (250, 5e-4), xtol=1e-14, ftol=1e-14)
    fit = nonlinear(saturation, start, jacobian=jacobian, names=["b1", "b2"])
    # MINPACK stops at the rounding of the sum of squares, 1e-8 of a deviation; forward differences in its covariance
    assert_allclose(fit.estimate, other, rtol=1e-6)
    assert_allclose(fit.standard_deviation, np.sqrt(np.diag(covariance)), rtol=1e-4)
    assert_allclose(fit.residuals, saturation(fit.estimate), rtol=0, atol=0)
    assert 0 < fit.evaluations < 100


def test_line_as_scipy_has_it():
    rng = np.random.default_rng(1)
    x, y = rng.standard_normal((2, 30))
    other, line = stats.linregress(x, y), linear(np.stack([np.ones(30), x], axis=1), y)
    assert_allclose(line.estimate, [other.intercept, other.slope], rtol=1e-13)  # well conditioned: rounding
    assert_allclose(line.standard_deviation, [other.intercept_stderr, other.stderr], rtol=1e-13)


def test_exact_small_case():
    # generalised least squares with a prior, in rationals: what the normal equations say where there is no rounding
    A = sympy.Matrix([[1, 0], [1, 1], [1, 2], [1, 4]])
    y = sympy.Matrix([1, 3, sympy.Rational(21, 4), 8])
    V = sympy.Matrix([[2, 1, 0, 0], [1, 3, 1, 0], [0, 1, 4, 1], [0, 0, 1, 5]])
    P, m = sympy.Matrix([[3, 1], [1, 2]]), sympy.Matrix([2, 1])
    C = (A.T * V.inv() * A + P.inv()).inv()
    x = C * (A.T * V.inv() * y + P.inv() * m)
    r = y - A * x
    chi_square = (r.T * V.inv() * r + (x - m).T * P.inv() * (x - m))[0]
    hat = A * C * A.T * V.inv()
    numeric = [np.array(matrix.tolist(), dtype=float) for matrix in (A, y, V, P, m)]
    fit = linear(
        numeric[0], numeric[1][:, 0], covariance=numeric[2], prior_covariance=numeric[3], prior_mean=numeric[4][:, 0]
    )
    rtol = 1e-14 * 20  # rounding times the condition of the design
    assert_allclose(fit.estimate, np.array(x.T.tolist(), dtype=float)[0], rtol=rtol)
    assert_allclose(fit.covariance, np.array(C.tolist(), dtype=float), rtol=rtol)
    assert_allclose(fit.chi_square, float(chi_square), rtol=rtol)
    assert_allclose(fit.leverage, [float(hat[i, i]) for i in range(4)], rtol=rtol)
    assert_allclose(fit.redundancy, [1 - float(hat[i, i]) for i in range(4)], rtol=rtol)
    assert fit.degrees_of_freedom == 4
    assert_allclose(fit.p_value, stats.chi2.sf(float(chi_square), 4), rtol=1e-12)  # another implementation


@given(seed=SEEDS)
def test_whitening_is_decorrelating_by_hand(seed):
    A, y, V = random_problem(np.random.default_rng(seed))
    variance, axes = np.linalg.eigh(V)  # principal axes: another root than the one under test
    fit = linear(A, y, covariance=V)
    turned = linear(axes.T @ A, axes.T @ y, standard_deviation=np.sqrt(variance))
    assert_allclose(fit.estimate, turned.estimate, rtol=1e-6, atol=1e-8)  # condition of V up to 1e6, of A up to 100
    assert_allclose(fit.covariance, turned.covariance, rtol=1e-6, atol=1e-8)
    assert_allclose(fit.chi_square, turned.chi_square, rtol=1e-6)
    assert_allclose(fit.whitened_residuals @ fit.whitened_residuals, fit.chi_square, rtol=1e-12)
    assert_allclose(fit.leverage.sum(), 4, rtol=1e-6)  # trace of a projection


@given(seed=SEEDS, exponents=st.lists(st.integers(-12, 12), min_size=4, max_size=4))
def test_column_scaling_and_row_order_do_not_matter(seed, exponents):
    rng = np.random.default_rng(seed)
    A, y, _ = random_problem(rng)
    sigma, factors, order = rng.uniform(0.5, 2, 12), 10.0 ** np.array(exponents), rng.permutation(12)
    fit = linear(A, y, standard_deviation=sigma)
    other = linear((A * factors)[order], y[order], standard_deviation=sigma[order])
    # rounding times a condition that random 12 x 4 designs keep below 1e3
    assert_allclose(other.estimate * factors, fit.estimate, rtol=1e-9, atol=1e-11)
    assert_allclose(other.standard_deviation * factors, fit.standard_deviation, rtol=1e-10)
    assert_allclose(other.condition, fit.condition, rtol=1e-10)
    assert_allclose(other.residuals, fit.residuals[order], rtol=0, atol=1e-10)


@given(seed=SEEDS)
def test_equal_to_lstsq(seed):
    A, y, _ = random_problem(np.random.default_rng(seed))
    fit, (other, squares, *_) = linear(A, y), np.linalg.lstsq(A, y, rcond=None)
    assert_allclose(fit.estimate, other, rtol=1e-9, atol=1e-11)  # rounding times condition, below 1e3
    assert_allclose(fit.chi_square, squares[0], rtol=1e-10)


@given(seed=SEEDS)
def test_wide_prior_changes_nothing(seed):
    A, y, _ = random_problem(np.random.default_rng(seed))
    fit = linear(A, y, standard_deviation=0.3)
    wide = linear(A, y, standard_deviation=0.3, prior_standard_deviation=1e9, prior_mean=5.0)
    none = linear(A, y, standard_deviation=0.3, prior_standard_deviation={})
    # the prior weighs (0.3 / 1e9)**2 of the data, times the squared condition
    assert_allclose(wide.estimate, fit.estimate, rtol=1e-9, atol=1e-11)
    assert_allclose(wide.covariance, fit.covariance, rtol=1e-9, atol=1e-12)
    assert wide.degrees_of_freedom == fit.degrees_of_freedom + 4  # four more rows
    assert_array_equal(none.estimate, fit.estimate)
    assert none.degrees_of_freedom == fit.degrees_of_freedom


@given(seed=SEEDS)
def test_prior_alone_returns_the_prior(seed):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((3, 3)) + 3 * np.eye(3)
    mean, P = rng.standard_normal(3), root @ root.T
    fit = linear(
        np.zeros((2, 3)), np.zeros(2), standard_deviation=1, prior_mean=mean, prior_covariance=P, names=["a", "b", "c"]
    )
    assert_allclose(fit.estimate, mean, rtol=1e-8, atol=1e-10)  # condition of P up to some 1e4
    assert_allclose(fit.covariance, P, rtol=1e-8, atol=1e-8)
    assert_allclose(fit.correlation, P / np.sqrt(np.outer(np.diag(P), np.diag(P))), rtol=1e-8, atol=1e-8)
    assert fit.rank == 0 and fit.undetermined == () and fit.unobservable_parameters() == ("a", "b", "c")
    assert_allclose(fit.leverage, 0, atol=1e-15)


def test_priors_in_three_forms_agree():
    A, y, _ = random_problem(np.random.default_rng(3))
    common = {"standard_deviation": 0.5, "names": ["a", "b", "c", "d"]}
    fits = [
        linear(A, y, **common, prior_standard_deviation={"b": 0.1, "d": 2}, prior_mean={"b": 1}),
        linear(A, y, **common, prior_standard_deviation=[np.inf, 0.1, np.inf, 2], prior_mean=[9, 1, 9, 0]),
        linear(A, y, **common, prior_covariance=np.diag([np.inf, 0.01, np.inf, 4]), prior_mean=[9, 1, 9, 0]),
        nonlinear(
            lambda x: y - A @ x, np.zeros(4), **common, prior_standard_deviation={"b": 0.1, "d": 2}, prior_mean={"b": 1}
        ),
    ]
    nothing = linear(A, y, **common, prior_covariance=np.diag(np.full(4, np.inf)))
    assert_array_equal(nothing.estimate, linear(A, y, **common).estimate)
    for fit in fits[1:]:
        assert_allclose(fit.estimate, fits[0].estimate, rtol=1e-9)  # central differences of a linear model: rounding
        assert_allclose(fit.covariance, fits[0].covariance, rtol=1e-8)
        assert_allclose(fit.chi_square, fits[0].chi_square, rtol=1e-9)
        assert fit.degrees_of_freedom == fits[0].degrees_of_freedom == 10


def test_scale_known_up_to_a_factor():
    A, y, V = random_problem(np.random.default_rng(5))
    fit = linear(A, y, covariance=V, scale="estimated")
    larger = linear(A, y, covariance=100 * V, scale="estimated")
    assert_allclose(larger.covariance, fit.covariance, rtol=1e-12)  # a factor of the noise cancels, to rounding
    given = linear(A, y, covariance=V * fit.noise_scale**2)
    assert_allclose(given.covariance, fit.covariance, rtol=1e-12)
    assert_allclose(given.chi_square, given.degrees_of_freedom, rtol=1e-12)


def test_badly_scaled_columns_are_recovered():
    rng = np.random.default_rng(6)
    sizes = 10.0 ** np.array([-12, -8, -3, 0, 6])
    A = rng.standard_normal((40, 5)) * sizes
    truth = rng.standard_normal(5) / sizes
    fit = linear(A, A @ truth)
    assert_allclose(fit.estimate, truth, rtol=1e-14 * 10)  # rounding times a condition of 2
    assert fit.condition < 10
    searched = nonlinear(lambda x: A @ (truth - x), np.zeros(5), jacobian=lambda x: -A)
    assert_allclose(searched.estimate, truth, rtol=1e-13)
    searched = nonlinear(lambda x: A @ (truth - x), np.zeros(5), parameter_scale=1 / sizes)
    assert_allclose(searched.estimate, truth, rtol=1e-12)  # converges to rounding whatever the derivative's 1e-10


@pytest.mark.parametrize("door", ["linear", "analytic", "numeric"])
def test_planted_null_directions_are_named(door):
    rng = np.random.default_rng(7)
    A = rng.standard_normal((30, 6)) * [1e-6, 1, 1e6, 1, 1, 1]
    A[:, 2] = 2e6 * A[:, 1]  # moving b by 1 and c by -5e-7 changes nothing
    A[:, 5] = A[:, 3] - A[:, 4]  # nor d by 1, e by -1, f by -1
    truth, names = np.array([2e6, 1, 1e-6, 3, 4, 5]), list("abcdef")
    y = A @ truth
    if door == "linear":
        fit = linear(A, y, standard_deviation=1e-3, names=names)
    else:
        jacobian = {"analytic": lambda x: -A, "numeric": None}[door]
        fit = nonlinear(lambda x: y - A @ x, truth * 1.1, jacobian=jacobian, standard_deviation=1e-3, names=names)
    assert fit.rank == 4 and fit.condition == np.inf
    first, second = fit.unobservable
    # the decomposition finds the direction to rounding; central differences to some 1e-9 of the model's size
    tolerance = 1e-12 if door != "numeric" else 1e-7
    assert first == pytest.approx({"b": 1, "c": -5e-7}, rel=tolerance)
    assert second == pytest.approx({"d": 1, "e": -1, "f": -1}, rel=tolerance)
    assert fit.unobservable_parameters() == ("b", "c", "d", "e", "f")
    assert fit.undetermined == fit.unobservable
    assert_allclose(fit["a"], 2e6, rtol=1e-9)
    assert_array_equal(np.isnan(fit.estimate), [False] + [True] * 5)
    assert_array_equal(np.isinf(fit.standard_deviation), [False] + [True] * 5)
    assert_allclose(fit.residuals, 0, atol=1e-9)
    with pytest.raises(ValueError, match=r"the plan does not determine `b`, `c`, `d`, `e`, `f`: .*`b` -5e-07 `c`; "):
        fit.raise_if_unobservable("the plan")


def test_column_without_effect_is_named():
    fit = linear([[1, 0], [2, 0]], [1, 2], standard_deviation=1, names=["k", "gamma_xz"])
    assert fit.unobservable == ({"gamma_xz": 1.0},)
    assert_allclose(fit["k"], 1, rtol=1e-15)
    with pytest.raises(
        ValueError, match="the data does not determine `gamma_xz`: no observation depends on `gamma_xz`"
    ):
        fit.raise_if_unobservable()


def test_fewer_observations_than_parameters():
    fit = linear([[1.0, 1.0, 0.0]], [2.0], standard_deviation=1, names=["a", "b", "c"])
    assert [set(direction) for direction in fit.unobservable] == [{"a", "b"}, {"c"}]
    assert fit.rank == 1 and fit.degrees_of_freedom == 0 and np.isnan(fit.p_value)


def test_prior_determines_what_the_data_do_not():
    # the sum a + b = 3 is measured to 0.1; b = 1 is known to 0.2 beforehand
    fit = linear(
        [[1, 1]],
        [3],
        standard_deviation=0.1,
        prior_mean={"b": 1},
        prior_standard_deviation={"b": 0.2},
        names=["a", "b"],
    )
    assert_allclose(fit.estimate, [2, 1], rtol=1e-14)  # rounding
    assert_allclose(fit.covariance, [[0.05, -0.04], [-0.04, 0.04]], rtol=1e-13)  # 0.1**2 + 0.2**2, by hand
    assert fit.unobservable_parameters() == ("a", "b")
    assert fit.undetermined == ()
    fit.raise_if_unobservable(priors_help=True)
    with pytest.raises(ValueError, match="`a`, `b`"):
        fit.raise_if_unobservable()


def test_collinear_columns_warn():
    rng = np.random.default_rng(8)
    A = rng.standard_normal((50, 3))
    A[:, 2] = A[:, 0] + 3e-9 * rng.standard_normal(50)
    with pytest.warns(UserWarning, match=r"`design` has the condition number \d\.\d+e\+08 .*: `a`, `c` are hardly"):
        linear(A, A[:, 1], standard_deviation=1, names=["a", "b", "c"])
    with pytest.warns(UserWarning, match="`jacobian` has the condition number"):
        nonlinear(lambda x: A[:, 1] - A @ x, [0, 1, 0], jacobian=lambda x: -A, standard_deviation=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a prior on one of the two separates them
        linear(A, A[:, 1], standard_deviation=1, prior_standard_deviation=[np.inf, np.inf, 1])


def test_monte_carlo_linear():
    rng = np.random.default_rng(9)
    A, _, V = random_problem(rng, count=10, parameters=3)
    spread = np.array([np.inf, 0.5, 2.0])  # of the truth about its prior, drawn anew each run
    runs, errors, p_values, scores = 2000, [], [], []
    for _ in range(runs):
        truth = np.where(np.isfinite(spread), spread, 0) * rng.standard_normal(3) + [7, 1, 0]
        y = A @ truth + np.linalg.cholesky(V) @ rng.standard_normal(10)
        fit = linear(A, y, covariance=V, prior_mean=[0, 1, 0], prior_standard_deviation=spread)
        errors.append(fit.estimate - truth)
        p_values.append(fit.p_value)
        scores.append(nees(errors[-1], fit.covariance))
    # probability 1 - 1e-4 each: three ratios, one average, one distribution
    low, high = ratio_interval(runs, 0.9999, mean_known=True)
    ratio = fit.standard_deviation / np.sqrt(np.mean(np.square(errors), axis=0))
    assert (low < ratio).all() and (ratio < high).all()
    low, high = chi_square_interval(3, runs, 0.9999)
    assert low < np.mean(scores) < high
    assert stats.kstest(p_values, "uniform").pvalue > 1e-4


def test_monte_carlo_estimated_scale():
    rng = np.random.default_rng(10)
    A, *_ = random_problem(rng, count=9, parameters=3)
    inside = 0
    for _ in range(2000):
        fit = linear(A, A @ [1, 2, 3] + 0.7 * rng.standard_normal(9))
        inside += abs(fit.estimate[1] - 2) < stats.t.ppf(0.975, 6) * fit.standard_deviation[1]
    assert abs(inside / 2000 - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 2000)  # 4 sigma of a share


def test_monte_carlo_nonlinear():
    rng = np.random.default_rng(11)
    time, truth = np.linspace(0, 4, 25), np.array([2.0, 0.5])
    errors, p_values, scores = [], [], []
    for _ in range(300):
        y = truth[0] * np.exp(-truth[1] * time) + 0.01 * rng.standard_normal(25)
        fit = nonlinear(
            lambda x, y=y: y - x[0] * np.exp(-x[1] * time),
            [1, 1],
            jacobian=lambda x: np.stack([-np.exp(-x[1] * time), x[0] * time * np.exp(-x[1] * time)], axis=1),
            standard_deviation=0.01,
        )
        errors.append(fit.estimate - truth)
        scores.append(nees(errors[-1], fit.covariance))
        p_values.append(fit.p_value)
    low, high = ratio_interval(300, 0.9999, mean_known=True)
    ratio = fit.standard_deviation / np.sqrt(np.mean(np.square(errors), axis=0))
    assert (low < ratio).all() and (ratio < high).all()
    low, high = chi_square_interval(2, 300, 0.9999)
    assert low < np.mean(scores) < high
    assert stats.kstest(p_values, "uniform").pvalue > 1e-4


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_nonlinear_in_any_unit(size):
    # an absolute stopping rule would stop at once in small units, or never in large ones
    time = np.linspace(0, 4, 25)
    fit = nonlinear(lambda x: size * (2 * np.exp(-0.5 * time) - x[0] * np.exp(-x[1] * time)), [1, 1])
    assert_allclose(fit.estimate, [2, 0.5], rtol=1e-12)  # noise-free: rounding


def test_nonlinear_starting_at_the_truth():
    fit = nonlinear(lambda x: np.array([x[0], x[0], x[1], 2 * x[1]]), [0, 0])
    assert_array_equal(fit.estimate, 0)


@pytest.mark.parametrize("unit", [None, 100.0, 0.01])
def test_search_begins_at_the_start(unit):
    # of the many zeros of the sine the nearest one is found
    fit = nonlinear(lambda x: np.array([np.sin(x[0]), 0.0]), [6.0], parameter_scale=unit)
    assert_allclose(fit.estimate, 2 * np.pi, rtol=1e-12)  # zero residual: rounding


def test_no_convergence_is_an_error():
    with pytest.raises(RuntimeError, match="no convergence in 2 evaluations of `residuals` from `start`"):
        nonlinear(saturation, [500, 1e-4], max_evaluations=2)
    with pytest.raises(RuntimeError, match=r"standard deviations from where .* Check `jacobian`"):
        nonlinear(saturation, [250, 5e-4], jacobian=lambda b: -saturation_jacobian(b))


A3, Y3 = [[1, 0], [1, 1], [1, 2]], [1, 2, 4]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"design": [1, 2, 3]}, "`design` must be an array with ndim 2"),
        ({"design": [[1, 0], [1, np.nan], [1, 2]]}, r"`design` must be finite, got nan at index \(1, 1\)"),
        ({"observations": [1, 2]}, r"`observations` must be of shape \(3,\)"),
        ({"observations": [1, 2, np.inf]}, "`observations` must be finite"),
        ({"standard_deviation": [1, -1, 1]}, "`standard_deviation` must be > 0, got -1.0 at index 1"),
        ({"standard_deviation": 0}, "`standard_deviation` must be > 0, got 0.0"),
        ({"standard_deviation": [1, 2]}, r"`standard_deviation` must be one number or of shape \(3,\), got \(2,\)"),
        ({"covariance": np.eye(2)}, r"`covariance` must be of shape \(3, 3\)"),
        ({"covariance": np.ones((3, 3))}, "`covariance` must be positive definite"),
        ({"covariance": np.eye(3) + (1 - 1.1e-16) * np.eye(3)[[1, 0, 2]] * [1, 1, 0]}, "must be positive definite"),
        ({"covariance": 1e-20 * (np.ones((3, 3)) - 3 * np.eye(3))}, "`covariance` must have a positive diagonal"),
        ({"covariance": [[1, 0.1, 0], [0.2, 1, 0], [0, 0, 1]]}, "`covariance` must be symmetric"),
        ({"covariance": np.eye(3), "standard_deviation": 1}, "`covariance` must be None where"),
        ({"names": ["a", "a"]}, "`names` must differ from each other, got 'a' more than once"),
        ({"names": ["a"]}, "`names` must name 2 parameters, got 1"),
        ({"scale": "given"}, "`scale` must be 'estimated' without"),
        ({"scale": "guessed"}, "`scale` must be one of 'given', 'estimated'"),
        ({"design": A3[:2], "observations": Y3[:2]}, "`observations` must be at least 3 to estimate the noise level"),
        ({"prior_mean": 0}, "`prior_mean` must come with"),
        ({"prior_standard_deviation": 1}, "`scale` must be 'given' with priors"),
        ({"prior_standard_deviation": [1, np.nan]}, "`prior_standard_deviation` must be > 0, got nan at index 1"),
        ({"prior_standard_deviation": [1, 2, 3]}, r"`prior_standard_deviation` must be one number or of shape \(2,\)"),
        ({"prior_standard_deviation": {"z": 1}}, "`prior_standard_deviation` must have keys among .*, got 'z'"),
        ({"prior_standard_deviation": 1, "prior_mean": [np.nan, 0]}, "`prior_mean` must be finite"),
        ({"prior_standard_deviation": 1, "prior_covariance": np.eye(2)}, "`prior_covariance` must be None where"),
        ({"prior_covariance": np.eye(3)}, r"`prior_covariance` must be of shape \(2, 2\)"),
        ({"prior_covariance": [[np.inf, 1], [1, 1]]}, "`prior_covariance` must be 0 off the diagonal where"),
        ({"prior_covariance": [[1, 1], [1, 1]]}, "`prior_covariance` must be positive definite"),
        ({"rank_tolerance": 0}, "`rank_tolerance`"),
    ],
)
def test_bad_input_is_named(change, words):
    with pytest.raises(ValueError, match=words):
        linear(**{"design": A3, "observations": Y3, **change})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"start": [[1, 2]]}, "`start` must be an array with ndim 1"),
        ({"start": [1, np.nan]}, "`start` must be finite"),
        ({"residuals": lambda x: np.full(3, np.nan)}, r"`residuals\(start\)` must be finite"),
        ({"residuals": lambda x: np.ones((3, 1))}, r"`residuals\(start\)` must be an array with ndim 1"),
        ({"jacobian": lambda x: np.ones((2, 3))}, r"`jacobian\(start\)` must be of shape \(3, 2\)"),
        ({"parameter_scale": [1, 0]}, "`parameter_scale` must be > 0, got 0.0 at index 1"),
        ({"max_evaluations": 0}, "`max_evaluations` must be an integer >= 1"),
    ],
)
def test_bad_nonlinear_input_is_named(change, words):
    def residuals(x):
        return np.array(Y3) - np.array(A3) @ x

    with pytest.raises(ValueError, match=words):
        nonlinear(**{"residuals": residuals, "start": [1, 1], **change})


def test_names_of_the_wrong_kind():
    with pytest.raises(TypeError, match="`names` must be a sequence of strings, got 'ab'"):
        linear(A3, Y3, names="ab")
    with pytest.raises(TypeError, match="`names` must be strings"):
        linear(A3, Y3, names=[1, 2])
