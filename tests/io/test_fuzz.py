"""300 recordings and descriptions, broken as files are: a result or one sentence, and no silent wrong result."""

import pytest
from iofuzz import run_case, sound


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_broken_recordings(first, tmp_path):
    outcomes = [(number, *run_case(number, tmp_path)) for number in range(first, first + 50)]
    assert not [case for case in outcomes if case[1] == "crash"]
    assert not [case for case in outcomes if case[1] == "good" and case[3]]
    assert {case[1] for case in outcomes} == {"good", "doubtful", "error"}


def test_every_kind_of_file_is_broken():
    assert {description.file.kind for description, _ in sound()} == {"csv", "npz", "parquet", "matlab"}
