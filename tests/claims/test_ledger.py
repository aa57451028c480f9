"""Reading the ledger: what is accepted, and what a malformed file says."""

import pytest

import fogkit
from fogkit import claims


def test_rows_in_the_order_of_the_file(write, rows):
    loaded = claims.load("fake", folder=write(rows))
    assert [claim.id for claim in loaded] == [row["id"] for row in rows]
    assert loaded[0].printed == "3,14"
    assert loaded[0].is_quantity
    assert not loaded[3].is_quantity
    assert loaded[5].code_paths == ["fogkit.claims.printed.Printed.parse"]


def test_table_holds_the_text(write, rows):
    table = claims.table(folder=write(rows))
    assert table.loc["fake-slip", "corrected"] == "2.51"
    assert list(table.columns) == list(claims.COLUMNS[1:])


def test_counts(write, rows):
    folder = write(rows)
    assert claims.counts(folder=folder) == {
        "fake": {"reproduced": 1, "corrected": 2, "refuted": 1, "undetermined": 1, "definition": 1, "total": 6}
    }
    write([rows[0] | {"id": "other-number", "paper": "other"}], "other")
    counts = claims.counts(folder=folder)
    assert list(counts) == ["fake", "other", "all papers"]
    assert counts["all papers"]["reproduced"] == 2
    assert counts["all papers"]["total"] == 7


@pytest.mark.parametrize(
    ("index", "change", "reason"),
    [
        (0, {"id": "other-number"}, "`id` must start with the paper's key 'fake'"),
        (0, {"id": "fake-Number"}, "`id` must be lower-case"),
        (0, {"paper": "other", "id": "other-number"}, "`paper` must be the name of the file, 'fake'"),
        (0, {"status": "confirmed"}, "`status` must be one of reproduced, corrected, .*, got 'confirmed'"),
        (0, {"where": ""}, "`where` is empty"),
        (0, {"quantity": " "}, "`quantity` is empty"),
        (0, {"printed": "3,14 or so"}, "`printed` of a row with a unit must be a number"),
        (0, {"printed": ""}, "`printed` is empty; only an undetermined"),
        (0, {"unit": ""}, "`unit` is empty, but `printed` is the number"),
        (0, {"corrected": "3.15"}, "`corrected` must be empty for the status reproduced"),
        (0, {"tolerance": "0.1"}, "`note` must give the reason for the `tolerance`"),
        (0, {"tolerance": "-1", "note": "why"}, "`tolerance` must be a non-negative number"),
        (0, {"tolerance": "wide", "note": "why"}, "`tolerance` must be a non-negative number"),
        (2, {"corrected": ""}, "`corrected` is empty, but the status is corrected"),
        (2, {"corrected": "2,15"}, "`corrected` repeats `printed`"),
        (2, {"corrected": "more"}, "`corrected` of a row with a unit must be a number"),
        (3, {"tolerance": "0.1"}, "`tolerance` has nothing to apply to"),
        (4, {"note": ""}, "`note` must name the input that the paper does not give"),
        (5, {"note": "see the text"}, "`note` must name what implements the definition"),
    ],
)
def test_malformed_row_is_named_with_file_and_line(write, rows, index, change, reason):
    rows[index] |= change
    with pytest.raises(ValueError, match=rf"fake\.csv:{index + 2}: {reason}"):  # line 1 is the header
        claims.load("fake", folder=write(rows))


def test_id_twice(write, rows):
    with pytest.raises(ValueError, match=r"fake\.csv:8: `id` 'fake-number' is already on line 2"):
        claims.load("fake", folder=write([*rows, rows[0]]))


def test_every_fault_of_a_file_is_listed(write, rows):
    rows[0]["status"] = rows[3]["status"] = "so so"
    with pytest.raises(ValueError) as caught:
        claims.load("fake", folder=write(rows))
    assert str(caught.value).count("fake.csv:") == 2


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda text: text.replace(",note", "", 1), "missing: note"),
        (lambda text: text.replace(",note", ",remark", 1), "missing: note; unknown: remark"),
        (lambda text: text.replace("id,paper", "paper,id", 1), "another order"),
        (lambda text: "", "missing: id, paper"),
        (lambda text: text + "fake-x,fake,here\n", "10 cells are needed, got 3"),
    ],
)
def test_malformed_file(write, rows, change, reason):
    folder = write(rows)
    file = folder / "fake.csv"
    file.write_text(change(file.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(ValueError, match=reason):
        claims.load("fake", folder=folder)


def test_unknown_paper(write, rows):
    with pytest.raises(ValueError, match="`paper` must be one of fake, got 'other'"):
        claims.load("other", folder=write(rows))


def test_folder_of_an_installed_wheel_comes_first(tmp_path, monkeypatch):
    module = tmp_path / "site-packages" / "fogkit" / "claims" / "ledger.py"
    monkeypatch.setattr(fogkit.claims.ledger, "__file__", str(module))
    with pytest.raises(FileNotFoundError, match=r"_data.claims.*data.claims"):
        claims.claims_folder()
    in_repository = tmp_path / "data" / "claims"
    in_repository.mkdir(parents=True)
    assert claims.claims_folder() == in_repository
    in_wheel = tmp_path / "site-packages" / "fogkit" / "_data" / "claims"
    in_wheel.mkdir(parents=True)
    assert claims.claims_folder() == in_wheel
