"""Reading one CSV file: every way it can be broken is named, and nothing broken comes through."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.run_directory.csv_file import flag, number, read_table, read_texts, whole

COLUMNS = {
    "id": whole("which", "", 0, 2),
    "share": number("how much", "", 0, 1),
    "any": number("anything", "m"),
    "done": flag("whether"),
}
WHOLE = "id,share,any,done\n0,0.5,-7.25,True\n1,1,1e3,False\n2,0,0,True\n"


def read(folder: Path, text: str) -> str:
    """What is said of a file, or an empty text."""
    path = folder / "table.csv"
    path.write_bytes(text.encode())
    try:
        read_table(path, COLUMNS, num_rows=3, key=["id"])
    except UserError as error:
        return str(error)
    return ""


def test_a_whole_file_is_read_with_its_types(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text(WHOLE)
    rows = read_table(path, COLUMNS, 3, ["id"])
    assert rows.dtypes.to_dict() == {"id": np.int64, "share": np.float64, "any": np.float64, "done": np.bool_}
    assert rows["any"].tolist() == [-7.25, 1000.0, 0.0]
    assert rows["done"].tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (WHOLE, "", "table.csv cannot be read: it is empty"),
        (WHOLE, "\n \n", "table.csv cannot be read: it is empty"),
        ("\n2,0,0,True\n", "\n2,0,0,Tr", "table.csv is cut off: line 4 has no end"),
        ("True\n", "True", "table.csv is cut off: line 4 has no end"),
        ("\n2,0,0,True\n", "\n", "table.csv is cut off: 2 of 3 rows"),
        ("1,1,1e3,False\n", "1,1,1e3,False\n" * 2, "table.csv has 4 rows: must be 3"),
        ("1,1,1e3,False", "2,1,1e3,False", "table.csv line 4 repeats id 2: must be there once"),
        ("id,share", "id,portion", "table.csv lacks the columns share"),
        ("id,share,any,done\n", "id,share,any,done,more\n", "table.csv holds the unknown columns ['more']"),
        (WHOLE, "id,share,any,done\n" + "9,0,0.5,1,True\n" * 3, "more values in a line than its 4 columns"),
        ("2,0,0,True", "2,0,0,True,5,6", "table.csv cannot be read"),
        ("2,0,0,True", "2,0,0", "table.csv line 4: done = '': must be True or False"),
        ("2,0,0,True", "", "table.csv line 4: id = '': must be a whole number from 0 to 2"),
        ("0.5", "half", "table.csv line 2: share = 'half': must be a finite number from 0 to 1"),
        ("0.5", "-0.5", "table.csv line 2: share = '-0.5': must be a finite number from 0 to 1"),
        ("-7.25", "inf", "table.csv line 2: any = 'inf': must be a finite number"),
        ("-7.25", "nan", "table.csv line 2: any = 'nan': must be a finite number"),
        ("-7.25", "True", "table.csv line 2: any = 'True': must be a finite number"),
        ("1,1,1e3", "1.5,1,1e3", "table.csv line 3: id = '1.5': must be a whole number from 0 to 2"),
        ("1,1,1e3", "3,1,1e3", "table.csv line 3: id = '3': must be a whole number from 0 to 2"),
        ("False", "0", "table.csv line 3: done = '0': must be True or False"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_place(tmp_path: Path, old: str, new: str, expected: str) -> None:
    head, found, tail = WHOLE.rpartition(old)
    assert found
    assert expected in read(tmp_path, head + new + tail)


def test_a_table_without_rows_has_its_types_too(tmp_path: Path) -> None:
    """One of flags alone, and one of all kinds."""
    for columns in ({"done": COLUMNS["done"]}, COLUMNS):
        (tmp_path / "table.csv").write_text(",".join(columns) + "\n")
        rows = read_table(tmp_path / "table.csv", columns, 0, ["done"])
        assert len(rows) == 0
        assert rows["done"].dtype == bool


def test_a_missing_file_a_directory_and_binary_garbage_are_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"missing.csv cannot be read: No such file"):
        read_texts(tmp_path / "missing.csv", ())
    with pytest.raises(UserError, match="cannot be read: Is a directory"):
        read_texts(tmp_path, ())
    (tmp_path / "garbage.csv").write_bytes(bytes(range(256)))
    with pytest.raises(UserError, match=r"garbage.csv cannot be read: it is no text"):
        read_texts(tmp_path / "garbage.csv", ())


@given(st.integers(0, len(WHOLE) - 1))
def test_no_file_that_was_cut_anywhere_is_taken_for_whole(tmp_path_factory: pytest.TempPathFactory, at: int) -> None:
    assert read(tmp_path_factory.mktemp("cut"), WHOLE[:at])


@given(st.binary(max_size=200))
def test_random_bytes_are_refused_in_one_line(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.mktemp("noise") / "noise.csv"
    path.write_bytes(content)
    with pytest.raises(UserError) as refusal:
        read_table(path, COLUMNS, 3, ["id"])
    assert len(str(refusal.value).splitlines()) == 1
