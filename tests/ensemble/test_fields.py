"""Gaussian fields: their covariance is the analytic one, and they meet known values.

A field is a linear map of white noise. Unit vectors as noise give its matrix, so that covariances
are compared exactly, without samples.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix

from geosurf.ensemble.change import check_seed, probability_of, stream_of
from geosurf.ensemble.fields import MODELS, Covariance, FieldGrid, GaussianField
from geosurf.errors import InputError
from geosurf.model.distributions import (
    Constant,
    Discrete,
    Normal,
    Triangular,
    Uniform,
    distribution_of,
    reach_of,
)
from tests.messages import refused

# of the variance: what the seam of the torus leaves (`Covariance.independent`)
SEAM = {"gaussian": 2e-5, "exponential": 3e-4, "spherical": 1e-12}


class Unit:
    """White noise that is 1 at one node and 0 elsewhere."""

    def __init__(self, k):
        self.k = k

    def standard_normal(self, shape):
        noise = np.zeros(shape)
        noise.flat[self.k] = 1.0
        return noise


def matrix_of(field):
    """The matrix that makes a field from white noise, and what it is without any."""
    mean = field.simulate(Unit(slice(0, 0))).ravel()
    n = field.torus[0] * field.torus[1]
    return np.stack([field.simulate(Unit(k)).ravel() - mean for k in range(n)], axis=1), mean


def grid_of(n_row=6, n_col=5, cell=(40.0, 60.0), angle=0.0):
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    steps = np.array([[0.0, cell[0]], [cell[1], 0.0]]) @ turn
    return FieldGrid(np.array([1000.0, 2000.0]), steps, (n_row, n_col))


def places_of(grid):
    i, j = np.divmod(np.arange(grid.n_node), grid.shape[1])
    return grid.corner + i[:, None] * grid.steps[0] + j[:, None] * grid.steps[1]


def analytic(covariance, places):
    return covariance.at(np.hypot(*(places[:, None] - places[None, :]).transpose(2, 0, 1)))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_covariance_is_the_analytic_one(model, angle):
    covariance, grid = Covariance(12.0, 250.0, model), grid_of(angle=angle)
    made, mean = matrix_of(GaussianField(grid, covariance))
    expected = analytic(covariance, places_of(grid))
    assert np.abs(made @ made.T - expected).max() <= SEAM[model] * covariance.sd**2
    assert not mean.any()


@pytest.mark.parametrize("model", MODELS)
def test_conditioned_fields_are_those_of_simple_kriging(model):
    covariance, grid = Covariance(12.0, 250.0, model), grid_of()
    rng = np.random.default_rng(3)
    weights = np.zeros((4, grid.n_node))
    weights[0, 7] = 1.0  # a node, and places in triangles
    for k in (1, 2, 3):
        weights[k, rng.choice(grid.n_node, 3, replace=False)] = (0.2, 0.3, 0.5)
    values = np.array([5.0, -20.0, 3.0, 0.0])
    made, mean = matrix_of(GaussianField(grid, covariance, csr_matrix(weights), values))

    # the oracle: dense matrices of the analytic covariance
    plain = analytic(covariance, places_of(grid))
    gain = plain @ weights.T @ np.linalg.inv(weights @ plain @ weights.T)
    tolerance = 100 * SEAM[model]
    np.testing.assert_allclose(mean, gain @ values, atol=tolerance * covariance.sd)
    np.testing.assert_allclose(
        made @ made.T, plain - gain @ weights @ plain, atol=tolerance * covariance.sd**2
    )


def test_weights_are_exact_at_nodes_and_for_planes():
    grid = grid_of(9, 8, angle=0.3)
    nodes = grid.weights_at(places_of(grid)).toarray()
    np.testing.assert_allclose(nodes, np.eye(grid.n_node), atol=1e-12)

    inner = np.random.default_rng(2).uniform(1.0, 6.0, size=(50, 2))
    places = grid.corner + inner @ grid.steps
    plane = places_of(grid) @ [0.3, -0.7]
    np.testing.assert_allclose(grid.weights_at(places) @ plane, places @ [0.3, -0.7], atol=1e-9)


def test_impossible_fields_are_refused():
    grid = grid_of(40, 40)
    refused(InputError, "range is 0; give metres above 0", Covariance, 1.0, 0)
    with pytest.raises(InputError, match=r"model is 'gausian'.*Did you mean 'gaussian'"):
        Covariance(1.0, 100.0, "gausian")
    with pytest.raises(InputError, match=r"needs .* nodes, more than"):
        GaussianField(grid, Covariance(1.0, 1e6))
    twice = grid.weights_at(grid.corner + np.array([[500.0, 400.0], [500.0, 400.0]]))
    with pytest.raises(InputError, match=r"cannot be met together with the others.*Leave one"):
        GaussianField(grid, Covariance(9.0, 500.0), twice, np.array([0.0, 5.0]))


# ---- Distributions: quantiles rise, invert the textbook's distribution functions, and stay inside.
SAME = [  # ours, and what scipy calls it
    (Normal(3.0, 10.0), scipy.stats.norm(3.0, 10.0)),
    (Normal(3.0, 10.0, low=-5.0), scipy.stats.truncnorm(-0.8, np.inf, 3.0, 10.0)),
    (Normal(3.0, 10.0, -5.0, 8.0), scipy.stats.truncnorm(-0.8, 0.5, 3.0, 10.0)),
    (Uniform(-2.0, 6.0), scipy.stats.uniform(-2.0, 8.0)),
    (Triangular(-1.0, 0.0, 3.0), scipy.stats.triang(0.25, -1.0, 4.0)),
    (Triangular(0.0, 0.0, 3.0), scipy.stats.triang(0.0, 0.0, 3.0)),
]


@pytest.mark.parametrize(("ours", "theirs"), SAME, ids=[str(ours) for ours, _ in SAME])
def test_quantiles_are_those_of_scipy(ours, theirs):
    at = np.linspace(0.001, 0.999, 41)
    np.testing.assert_allclose([ours.quantile(p) for p in at], theirs.ppf(at), atol=1e-6)
    wrapped = distribution_of(theirs, "the shift")
    assert [wrapped.quantile(p) for p in at] == theirs.ppf(at).tolist()


@given(st.lists(st.floats(2**-54, 1 - 2**-53), min_size=2, max_size=9))
def test_quantiles_rise_and_stay_between_the_limits(at):
    for made in (Normal(0.0, 1.0, -3.0, 3.0), Uniform(-3.0, 3.0), Triangular(-3.0, 2.0, 3.0),
                 Discrete([-3.0, 0.0, 3.0], [1, 5, 2]), Constant(2.0)):  # fmt: skip
        values = [made.quantile(p) for p in sorted(at)]
        assert values == sorted(values)
        assert -3.0 <= values[0] <= values[-1] <= 3.0


def test_values_are_drawn_as_often_as_their_weights():
    made = Discrete([1.0, 2.0, 5.0], [1, 2, 1])
    drawn = [made.quantile((k + 0.5) / 400) for k in range(400)]
    assert [drawn.count(value) for value in made.values] == [100, 200, 100]


def test_reach_is_the_largest_value_that_is_likely():
    assert reach_of(Uniform(-7.0, 3.0)) == pytest.approx(7.0, abs=1e-4)
    assert reach_of(Constant(-4.0)) == 4.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Normal(0, 0), "sd must be above 0"),
        (lambda: Normal(0, 1, low=5, high=2), "low must be below high"),
        (lambda: Normal(0, 1, low=50), "almost no value lies between the limits"),
        (lambda: Uniform(3, 3), "low must be below high"),
        (lambda: Triangular(0, 5, 4), "rising order"),
        (lambda: Discrete([]), "one weight above 0 for each value"),
        (lambda: Discrete([1, "2"]), "must be finite numbers"),
        (
            lambda: distribution_of("5", "the throw"),
            "the throw is '5', which is not a distribution",
        ),
        (lambda: distribution_of(scipy.stats.norm(0, -1), "the throw"), "not finite"),
        (lambda: check_seed(-1), "seed is -1; give a whole number"),
    ],
)
def test_impossible_parameters_are_refused(make, words):
    refused(InputError, words.replace("(", r"\("), make)


def test_streams_depend_on_seed_realisation_and_parameter_only():
    def draw(*key):
        return probability_of(stream_of(*key))

    keys = [(seed, k, name) for seed in (0, 1, 2**70) for k in (0, 1, 99) for name in "ab"]
    values = {key: draw(*key) for key in keys}
    assert len(set(values.values())) == len(keys)
    assert all(draw(*key) == values[key] for key in reversed(keys))


def test_uniform_numbers_of_many_realisations_are_uniform():
    drawn = np.array([probability_of(stream_of(7, k, "throw F1")) for k in range(2000)])
    assert scipy.stats.kstest(drawn, "uniform").pvalue > 1e-3
    lag = np.corrcoef(drawn[:-1], drawn[1:])[0, 1]
    assert abs(lag) < 4 / np.sqrt(len(drawn))
