"""Truth from outside: certified NIST data sets, exact rationals, numpy and scipy, and Monte Carlo."""

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

# NIST Statistical Reference Datasets, https://www.itl.nist.gov/div898/strd/: data and certified values.
NORRIS = np.array(
    """0.1 0.2 338.8 337.4 118.1 118.2 888.0 884.6 9.2 10.1 228.1 226.5 668.5 666.3 998.5 996.3 449.1 448.6 778.9 777.0
    559.2 558.2 0.3 0.4 0.1 0.6 778.1 775.5 668.8 666.9 339.3 338.0 448.9 447.5 10.8 11.6 557.7 556.0 228.3 228.1
    998.0 995.8 888.8 887.6 119.6 120.2 0.3 0.3 0.6 0.3 557.6 556.8 339.3 339.1 888.0 887.2 998.5 999.0 778.9 779.0
    10.2 11.1 117.6 118.3 228.9 229.2 668.4 669.1 449.2 448.9 0.2 0.5""".split(),
    dtype=float,
).reshape(-1, 2)
LONGLEY = np.array(
    """60323 83.0 234289 2356 1590 107608 1947 61122 88.5 259426 2325 1456 108632 1948
    60171 88.2 258054 3682 1616 109773 1949 61187 89.5 284599 3351 1650 110929 1950
    63221 96.2 328975 2099 3099 112075 1951 63639 98.1 346999 1932 3594 113270 1952
    64989 99.0 365385 1870 3547 115094 1953 63761 100.0 363112 3578 3350 116219 1954
    66019 101.2 397469 2904 3048 117388 1955 67857 104.6 419180 2822 2857 118734 1956
    68169 108.4 442769 2936 2798 120445 1957 66513 110.8 444546 4681 2637 121950 1958
    68655 112.6 482704 3813 2552 123366 1959 69564 114.2 502601 3931 2514 125368 1960
    69331 115.7 518173 4806 2572 127852 1961 70551 116.9 554894 4007 2827 130081 1962""".split(),
    dtype=float,
).reshape(-1, 7)
MISRA1A_Y = np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78])
MISRA1A_X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])


def misra1a(b):
    return MISRA1A_Y - b[0] * (1 - np.exp(-b[1] * MISRA1A_X))


def misra1a_jacobian(b):
    decay = np.exp(-b[1] * MISRA1A_X)
    return -np.stack([1 - decay, b[0] * MISRA1A_X * decay], axis=1)


def random_problem(rng, count=12, parameters=4):
    """Design, observations and a noise covariance with no structure."""
    root = rng.standard_normal((count, count)) + 3 * np.eye(count)
    return rng.standard_normal((count, parameters)), rng.standard_normal(count), root @ root.T


def test_norris_certified():
    line = linear(np.stack([np.ones(36), NORRIS[:, 1]], axis=1), NORRIS[:, 0], names=["b0", "b1"])
    # certified to 15 digits; rounding times the condition number of 2 and cancellation in b0
    assert_allclose(line.estimate, [-0.262323073774029, 1.00211681802045], rtol=1e-11)
    assert_allclose(line.standard_deviation, [0.232818234301152, 0.429796848199937e-3], rtol=1e-12)
    assert_allclose(line.noise_scale, 0.884796396144373, rtol=1e-12)
    assert (line.degrees_of_freedom, line.rank, line.scale) == (34, 2, "estimated")
    assert np.isnan(line.p_value)  # the scatter set the scale, so it tests nothing


def test_longley_certified():
    fit = linear(np.column_stack([np.ones(16), LONGLEY[:, 1:]]), LONGLEY[:, 0])
    certified = [-3482258.63459582, 15.0618722713733, -0.358191792925910e-1, -2.02022980381683, -1.03322686717359]
    certified += [-0.511041056535807e-1, 1829.15146461355]
    deviations = [890420.383607373, 84.9149257747669, 0.334910077722432e-1, 0.488399681651699, 0.214274163161675]
    deviations += [0.226073200069370, 455.478499142212]
    # condition 43275 with columns of unit length (Belsley's value), 2e-16 of rounding, and 15.06 is small beside its
    # deviation of 85; normal equations would have lost 1e-7
    assert_allclose(fit.condition, 43275, rtol=1e-4)
    assert_allclose(fit.estimate, certified, rtol=1e-9)
    assert_allclose(fit.standard_deviation, deviations, rtol=1e-10)
    assert_allclose(fit.noise_scale, 304.854073561965, rtol=1e-11)


@pytest.mark.parametrize("start", [(500, 1e-4), (250, 5e-4)])
@pytest.mark.parametrize("jacobian", [None, misra1a_jacobian])
def test_misra1a_certified(start, jacobian):
    fit = nonlinear(misra1a, start, jacobian=jacobian, names=["b1", "b2"])
    # certified to 11 digits; the covariance carries the error 4e-11 of central differences times the condition of 50
    assert_allclose(fit.estimate, [238.94212918, 5.5015643181e-4], rtol=2e-9)
    assert_allclose(fit.standard_deviation, [2.7070075241, 7.2668688436e-6], rtol=1e-8)
    assert_allclose(fit.chi_square, 0.12455138894, rtol=1e-10)
    assert_allclose(fit.residuals, misra1a(fit.estimate), rtol=0, atol=0)
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
        nonlinear(misra1a, [500, 1e-4], max_evaluations=2)
    with pytest.raises(RuntimeError, match=r"standard deviations from where .* Check `jacobian`"):
        nonlinear(misra1a, [250, 5e-4], jacobian=lambda b: -misra1a_jacobian(b))


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
