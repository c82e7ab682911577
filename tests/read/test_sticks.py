"""Fault sticks with names: Charisma, tables with a header, and columns that a caller names."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.conventions.checks import no_data_in
from geosurf.errors import FormatError, InputError
from geosurf.read.registry import SIGNATURES

CHARISMA = (
    "INLINE-   1201  3405  461000.10 5932000.50  1500.25 F1 1\n"
    "INLINE-   1201  3410  461050.00 5932000.00  1600.00 F1 1\n"
    "INLINE-\t1211\t3405\t461000.1\t5932100.5\t1500.25\tF1\t2\n"
    "INLINE- 1211 3410 461050 5932100 1600 F1 2\n"
    "XLINE- 0 0 461500 5932000 1500 Main fault 2b 1\n"
    "XLINE- 0 0 461550 5932000 1700 Main fault 2b 1\n"
)
# as Kingdom and SeisWorks write them: more columns, no header
COLUMNS = (
    "12 7 K 461000.10 5932000.50 1500.25 F1 1 x\n12 8 K 461050 5932000 1600 F1 1 x\n"
    "12 7 K 461000 5932100 1500 F2 1 x\n12 8 K 461050 5932100 1600 F2 1 x\n"
)
TABLE = (
    "X_UTME{0}Y_UTMN{0}Z_TVDSS{0}POLY_ID{0}NAME\n461000.1{0}5932000.5{0}1500.25{0}0{0}F1\n"
    "461050{0}5932000{0}1600{0}0{0}F1\n461000{0}5932100{0}1500{0}0{0}F2\n"
    "461050{0}5932100{0}1600{0}0{0}F2\n"
)


def written(tmp_path, text, name="faults.dat"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def test_charisma_is_recognised_and_asks_for_the_fault(tmp_path):
    path = written(tmp_path, CHARISMA, "faults")
    fault = gs.read_fault(path, name="F1", positive="down")
    assert [len(stick) for stick in fault.sticks] == [2, 2]
    assert fault.sticks[0].tolist() == [[461000.1, 5932000.5, -1500.25], [461050, 5932000, -1600]]
    assert gs.read_fault(path, name="Main fault 2b", positive="up").sticks[0][1, 2] == 1700
    with pytest.raises(InputError, match=r"has 2 faults: F1, Main fault 2b\. Choose one"):
        gs.read_fault(path, positive="down")
    found = gs.info(path)
    assert (found.format, found.read_with, found.count) == ("charisma", "read_fault", 6)
    assert found.notes["names"] == "2 faults: F1, Main fault 2b"
    assert sum(fits(CHARISMA.encode()) for fits in SIGNATURES.values()) == 1


@pytest.mark.parametrize(
    ("text", "name", "columns"),
    [
        (COLUMNS, "a.dat", (4, 5, 6, 8, 7)),
        (TABLE.format(","), "a.csv", None),
        (TABLE.format("\t"), "a.txt", None),
        (TABLE.format(","), "a.csv", ("X_UTME", "Y_UTMN", "Z_TVDSS", "POLY_ID", "NAME")),
        (TABLE.format(","), "a.csv", (1, 2, 3, 4, 5)),
    ],
)
def test_tables_with_names_hold_several_faults(tmp_path, text, name, columns):
    path = written(tmp_path, text, name)
    for key, y in (("F1", 5932000.0), ("F2", 5932100.0)):
        fault = gs.read_fault(path, name=key, positive="down", columns=columns)
        assert (fault.name, len(fault.sticks), fault.sticks[0][1, 1]) == (key, 1, y)
        (line,) = gs.read_polygons(path, name=key, positive="down", columns=columns)
        assert (line == fault.sticks[0]).all()
    with pytest.raises(InputError, match=r"has 2 faults: F1, F2\. Choose one, as in name='F1'"):
        gs.read_fault(path, positive="down", columns=columns)
    assert len(gs.read_polygons(path, positive="down", columns=columns)) == 2


def test_a_stick_column_alone_splits_lines(tmp_path):
    path = written(tmp_path, "1 2 3 7\n4 5 6 7\n1 3 3 8\n4 6 6 8\n")
    fault = gs.read_fault(path, positive="up", columns=(1, 2, 3, 4))
    assert (fault.name, len(fault.sticks)) == ("faults", 2)


@given(
    st.dictionaries(
        st.text(st.characters(codec="ascii", categories=["L", "N"]), min_size=1, max_size=5),
        st.lists(
            st.lists(
                st.tuples(*[st.floats(-1e7, 1e7, allow_subnormal=False)] * 3).filter(
                    lambda one: no_data_in(np.array([one])) is None
                ),
                min_size=2, max_size=4,
            ),
            min_size=1, max_size=3,
        ),
        min_size=1, max_size=3,
    )
)  # fmt: skip
def test_law_sticks_come_back(tmp_path_factory, faults):
    path = tmp_path_factory.mktemp("s") / "a"
    path.write_text(
        "".join(
            f"INLINE- 1 2 {x!r} {y!r} {z!r} {name} {k}\n"
            for name, sticks in faults.items()
            for k, stick in enumerate(sticks)
            for x, y, z in stick
        )
    )
    for name, sticks in faults.items():
        back = gs.read_fault(path, name=name, positive="up")
        assert [np.array(s).tolist() for s in back.sticks] == [np.array(s).tolist() for s in sticks]


DAMAGES = {
    "word": (CHARISMA.replace("1500.25 F1", "15oo F1", 1), {"format": "charisma"}, "'15oo'"),
    "short": (CHARISMA + "INLINE- 1 2 3 4\n", {}, "line 7: found 'INLINE- 1 2 3 4', expected"),
    "again": (CHARISMA + CHARISMA[:56] + "\n", {}, "'F1 1' continues after another one began"),
    "one": (CHARISMA + "XLINE- 1 2 3 4 5 F9 1\n", {"name": "F9"}, "line 7: stick 0 .* 1 point"),
    "open": (COLUMNS, {}, r"This line is: 1 '12', 2 '7', 3 'K', 4 '461000.10'"),
    "few": (COLUMNS, {"columns": (4, 5, 6, 19)}, "line 1: found 9 values, expected at least 19"),
    "no column": (TABLE.format(","), {"columns": ("X_UTME", "Y_UTMN", "Z_TVDSS", "S")}, "'s'"),
    "noise": ("\x01\x02\x7f\n" * 9, {}, r"line 1: found 0 columns for x.*or set columns="),
}  # fmt: skip


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_sticks_get_one_sentence(tmp_path, case):
    text, words, message = DAMAGES[case]
    path = written(tmp_path, text, "a.csv" if text.startswith("X_") else "a.dat")
    with pytest.raises(FormatError, match=message):
        gs.read_fault(path, positive="up", **{"name": "F1"} | words)
