"""The ledger as pages of the book."""

import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from fogkit import claims

BOOK = Path(__file__).resolve().parents[2] / "book"
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


class Page(HTMLParser):
    """Open tags, rows of the table, and the text of its cells; fails on tags that do not match."""

    VOID = frozenset({"br", "input"})

    def __init__(self, text):
        super().__init__()
        self.open, self.rows, self.tags = [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "td" in self.open or "th" in self.open:
            self.rows[-1][-1] += data


@pytest.fixture
def page(write, rows, values):
    return claims.ledger_html(folder=write(rows), values={"fake": values})


def test_counts_come_first_then_every_row(page, rows):
    cells = Page(page).rows
    assert cells[0] == ["Paper", *claims.STATUSES, "total"]
    assert cells[1] == ["fake", "1", "2", "1", "1", "1", "6"]
    assert [row[0] for row in cells[3:]] == [row["status"] + row["where"] + row["id"] for row in rows]
    assert cells[4][1:] == ["DifferenceIt is 0.2 %.", "<0.1 %", "0.2 %"]
    sign = ["Sign of <x>By sympy.", r"\(y = -x\)correct:\(y = +x\)", "print fails, correction holds"]
    assert cells[6][1:] == sign
    assert cells[3][3] == "3.14159"  # the unit of a pure number is not shown


def test_page_loads_nothing_from_elsewhere(page):
    assert not [attrs for _, attrs in Page(page).tags if {"src", "href"} & set(attrs)]
    assert "http" not in page
    assert "url(" not in page


@pytest.mark.parametrize("make", ["ledger_html", "errata_markdown"])
def test_no_page_shows_a_status_that_a_row_does_not_carry(write, rows, values, make):
    values["fake-slip"] = 2.15
    with pytest.raises(ValueError, match="fake-slip: corrected, but the print holds"):
        getattr(claims, make)("fake", folder=write(rows), values={"fake": values})


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium here: the filter of the ledger page is not tried")
@pytest.mark.parametrize(
    ("text", "paper", "status", "left"),
    [
        ("", "", "", 6),
        ("EQ.", "", "", 2),
        ("eq. ratio", "", "", 1),
        ("ratio drift", "", "", 0),
        ("", "fake", "corrected", 2),
        ("digits", "", "refuted", 0),
    ],
)
def test_filter_in_a_browser(page, tmp_path, text, paper, status, left):
    script = f"""<script>
      const form = document.querySelector("form"), wanted = {[text, paper, status]!r};
      [...form.elements].slice(0, 3).forEach((field, i) => field.value = wanted[i]);
      form.elements[0].dispatchEvent(new Event("input", {{bubbles: true}}));
      const left = [...document.querySelectorAll(".ledger-rows tbody tr")].filter(row => row.offsetHeight > 0).length;
      document.title = [left, form.offsetHeight > 0, document.querySelector("output").value].join("; ");
    </script>"""
    file = tmp_path / "page.html"
    file.write_text(f"<!doctype html><meta charset='utf-8'><body>{page}{script}", encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom"]
    done = subprocess.run([CHROMIUM, *options, file.as_uri()], capture_output=True, text=True, timeout=120, check=True)
    assert f"<title>{left}; true; {left} of 6 rows</title>" in done.stdout


def test_counts_markdown(write, rows):
    lines = claims.counts_markdown(folder=write(rows)).splitlines()
    assert lines[0] == "| paper | reproduced | corrected | refuted | undetermined | definition | total |"
    assert lines[2] == "| fake | 1 | 2 | 1 | 1 | 1 | 6 |"
    assert {line.count("|") for line in lines} == {8}


def test_errata_are_the_corrected_and_refuted_rows(write, rows, values):
    text = claims.errata_markdown("fake", folder=write(rows), values={"fake": values})
    assert text.split("\n\n")[2:4] == [
        "**Table 1: Drift** (corrected, `fake-slip`)",
        "- *Print:* 2,15 deg/h\n- *Correct:* 2.51 deg/h\n- *Computed:* 2.512 deg/h\n- *Why:* Digits swapped, a | b.",
    ]
    assert [word for word in ("fake-bound", "fake-sign") if word in text] == ["fake-bound", "fake-sign"]
    assert not [word for word in ("fake-number", "fake-lost", "fake-convention") if word in text]


def test_errata_of_a_faultless_paper(write, rows):
    folder = write(rows[:1])
    text = claims.errata_markdown("fake", folder=folder, values={"fake": {"fake-number": 3.14}})
    assert text == "No row of this paper is corrected or refuted."


@pytest.mark.skipif(not BOOK.is_dir(), reason="the book is not here: an installed package is tested")
def test_every_paper_has_its_errata_in_the_book():
    text = (BOOK / "errata.md").read_text(encoding="utf-8")
    assert [paper for paper in claims.papers() if f'errata_markdown("{paper}")' not in text] == []
