"""Distributions: quantiles rise, invert the textbook's distribution functions, and stay inside."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from geosurf.ensemble.change import check_seed, probability_of, stream_of
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
        (lambda: Normal(0, float("nan")), "sd is nan; give a finite number"),
        (lambda: Normal(0, 1, low=5, high=2), "low must be below high"),
        (lambda: Normal(0, 1, low=50), "almost no value lies between the limits"),
        (lambda: Uniform(3, 3), "low must be below high"),
        (lambda: Triangular(0, 5, 4), "rising order"),
        (lambda: Discrete([]), "one weight above 0 for each value"),
        (lambda: Discrete([1, 2], [1]), "one weight above 0 for each value"),
        (lambda: Discrete([1, "2"]), "must be finite numbers"),
        (
            lambda: distribution_of("5", "the throw"),
            "the throw is '5', which is not a distribution",
        ),
        (lambda: distribution_of(Normal, "the throw"), "is not a distribution"),
        (lambda: distribution_of(scipy.stats.norm(0, -1), "the throw"), "not finite"),
        (lambda: check_seed(-1), "seed is -1; give a whole number"),
        (lambda: check_seed(0.5), "seed is 0.5; give a whole number"),
    ],
)
def test_impossible_parameters_are_refused(make, words):
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        make()


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
