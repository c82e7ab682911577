"""Random arguments at every public function end by a result or by an error of geosurf."""

from __future__ import annotations

import warnings

from benchmarks.stress.random_arguments import outcome, run


def test_random_arguments_bring_out_no_foreign_exception():
    """As many as seconds allow; `random_arguments` makes thousands."""
    ended, defects = run(200, seed=7)
    assert defects == {}
    assert ended.total() == 200
    assert ended["taken"] > 5
    assert ended["refused"] > 50


def test_a_foreign_exception_and_a_foreign_warning_are_defects():
    """The run can fail: what is no error of geosurf is found."""

    def fails(value):
        return 1 / value

    def warns(value):
        warnings.warn("deprecated", DeprecationWarning, stacklevel=1)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert outcome("fails", fails, [], {"value": 0}) == ("defect", ": ZeroDivisionError")
        assert outcome("warns", warns, [], {"value": 0}) == ("defect", ": DeprecationWarning")
    assert outcome("fails", fails, [], {"values": 0})[0] == "no such argument"
    assert outcome("fails", fails, [], {"value": 2})[0] == "taken"
