"""A text in blocks is the whole text, whatever its line ends and the size of blocks."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import FormatError
from geosurf.read import _common
from geosurf.read._common import TextBlocks

words = st.text("01.e-+ \tné\n\r", max_size=60)


@given(words, st.integers(4, 9))
def test_law_blocks_join_to_the_text(text, size):
    text += "1\n"
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(_common, "BLOCK", size)
        path = Path(folder) / "a.txt"
        path.write_bytes(b"\xef\xbb\xbf" + text.encode())
        plain = text.replace("\r\n", "\n").replace("\r", "\n")
        found = list(TextBlocks(path))
        assert "".join(piece for _, piece in found) == plain
        starts = np.cumsum([1] + [piece.count("\n") for _, piece in found])[:-1]
        assert [line for line, _ in found] == starts.tolist()
        assert all(piece.endswith("\n") for _, piece in found)


def map_of_numbers(n, word="-1600.25", end="\n"):
    """A ZMAP+ map of n x n nodes; its last value is `word`."""
    body = [" -1600.25"] * (n * n - 1) + [f" {word}"]
    lines = ["".join(body[k : k + 5]) for k in range(0, len(body), 5)]
    head = ["@top, GRID, 5", "15, -99, , 2, 1"]
    return end.join([*head, f"{n}, {n}, 0, 10, 0, 10", "0, 0, 0", "@", *lines, ""])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_large_maps_with_all_line_ends(tmp_path, end):
    path = tmp_path / "top.zmap"
    path.write_bytes(map_of_numbers(300, "-99", end).encode())
    found = gs.read_horizon(path, positive="up").values
    assert np.isnan(found[0, -1])
    assert (found.ravel()[np.arange(found.size) != found.shape[1] - 1] == -1600.25).all()


@pytest.mark.parametrize("word", ["nan", "1D3", "1e999", "1-2", "1,5", "x", "-"])
def test_the_last_word_of_many_is_named_with_its_line(tmp_path, word):
    path = tmp_path / "top.zmap"
    text = map_of_numbers(300, word)
    path.write_text(text)
    line = text.count("\n")
    with pytest.raises(FormatError, match=f"top.zmap, line {line}: found '{word}'"):
        gs.read_horizon(path, positive="up")


def test_cut_files_are_refused(tmp_path):
    path = tmp_path / "top.zmap"
    text = map_of_numbers(300)
    path.write_text(text[: text.rindex("\n", 0, -1) + 1])
    with pytest.raises(FormatError, match="incomplete"):
        gs.read_horizon(path, positive="up")
    path.write_text(text[:-1])
    with pytest.warns(gs.errors.GeosurfWarning, match="no line end follows .* may be cut off"):
        gs.read_horizon(path, positive="up")
    path.write_text(text + "1\n")
    with pytest.raises(FormatError, match="found 90001 values, expected 90000"):
        gs.read_horizon(path, positive="up")


@pytest.mark.parametrize("n", [3, 300])  # read word by word, and in bulk
def test_a_map_without_values_has_no_decimal_points_to_miss(tmp_path, n):
    path = tmp_path / "top.zmap"
    path.write_text(map_of_numbers(n, "-99").replace("-1600.25", "-99"))
    assert np.isnan(gs.read_horizon(path, positive="up")).all()
    path.write_text(map_of_numbers(n, "5").replace("-1600.25", "-99"))
    with pytest.raises(FormatError, match="no value has a decimal point"):
        gs.read_horizon(path, positive="up")
