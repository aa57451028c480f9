"""Results, files and reports: exact round trips, damaged texts, pages that need nothing beside them."""

import json
import math
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fogkit.cli import files
from fogkit.cli.report import page
from fogkit.cli.results import Estimates, Result
from fogkit.io.errors import RecordingError
from fogkit.io.verdicts import Finding

NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


def result(values, text='β < 3 & "x"'):
    n = len(values)
    return Result(
        command="test",
        estimates=Estimates(names=[f"q{i}" for i in range(n)], units=["rad"] * n, values=values),
        findings=[Finding(check="gaps", severity="doubtful", text=text, time=values[0], factor=values[-1])],
        inputs=[{"name": "a.csv", "sha256": "0" * 64, "bytes": 3}],
        parameters={"x": values[0], "list": [1, "two", None], "flag": True},
        versions={"fogkit": "0"},
        tables={"series": {"time": np.array(values), "label": [f"ü{i}" for i in range(n)]}},
        correction={"form": "linear", "gyro": {"bias": list(values)}},
    )


@settings(max_examples=60, deadline=None)
@given(st.lists(NUMBERS, min_size=1, max_size=5), st.text(max_size=20))
def test_every_bit_comes_back(values, text):
    before = result(values, text)
    written = before.to_json()
    after = Result.from_json(written)
    assert after == before and after.to_json() == written
    # equal texts could hide a loss that both share: compare the bits themselves (a NaN's payload apart)
    for ours, theirs in zip(after.estimates.values.tolist(), values, strict=True):
        assert (math.isnan(ours) and math.isnan(theirs)) or np.float64(ours).tobytes() == np.float64(theirs).tobytes()
    json.loads(written, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_covariance_comes_back_and_gives_the_deviations():
    covariance = np.array([[4e-20, 1e-20], [1e-20, 9e-20]])
    estimates = Estimates(names=["a", "b"], units=["rad", "1"], values=[0.1, 1 / 3], covariance=covariance)
    after = Result.from_json(Result(command="c", estimates=estimates).to_json()).estimates
    assert (after.covariance == covariance).all()
    assert np.array_equal(after.standard_deviation, [2e-10, 3e-10])
    both = Estimates().joined(estimates).joined(Estimates(names=["c"], units=["1"], values=[1], covariance=[[1.0]]))
    assert both.covariance.shape == (3, 3) and both.covariance[0, 2] == 0 and both.covariance[0, 1] == 1e-20


DAMAGED = {
    "not JSON": lambda d: "{",
    "a list": lambda d: "[]",
    "another kind": lambda d: json.dumps(d | {"kind": "other"}),
    "another version": lambda d: json.dumps(d | {"version": 99}),
    "no estimates": lambda d: json.dumps({k: v for k, v in d.items() if k != "estimates"}),
    "too few values": lambda d: json.dumps(d | {"estimates": d["estimates"] | {"values": []}}),
    "a text for a number": lambda d: json.dumps(d | {"estimates": d["estimates"] | {"values": ["x"]}}),
    "a finding of no kind": lambda d: json.dumps(d | {"findings": [{"check": "x", "severity": "fine", "text": ""}]}),
    "estimates that are no table": lambda d: json.dumps(d | {"estimates": 3}),
}


@pytest.mark.parametrize("damage", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_result_is_said_in_one_sentence(damage):
    text = damage(json.loads(result([1.0]).to_json()))
    with pytest.raises(RecordingError, match=r"^r\.json ") as caught:
        Result.from_json(text, name="r.json")
    assert "\n" not in str(caught.value)


def test_a_file_is_whole_or_as_it_was(tmp_path, monkeypatch):
    target = tmp_path / "new" / "r.json"
    files.write_whole(target, "first")
    monkeypatch.setattr(files.os, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        files.write_whole(target, "second")
    assert target.read_text() == "first" and [p.name for p in target.parent.iterdir()] == ["r.json"]
    with pytest.raises(RecordingError, match="cannot be written"):
        files.write_whole(target / "below a file.json", "x")


class Page(HTMLParser):
    """Sources, and tags that are open."""

    def __init__(self):
        super().__init__()
        self.open, self.sources, self.tags = [], [], set()

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href", "srcset", "data")]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_a_report_needs_nothing_beside_it():
    tables = {
        "readings": {"time": np.arange(9.0)} | {f"gyro_{axis}": np.arange(9.0) for axis in "xyz"},
        "segments": {"kind": ["dwell", "turn"], "begin": np.array([0.0, 4.0]), "end": np.array([4.0, 8.0])},
        "departures": {"name": ["a", "b"], "departure": np.array([1.0, -2.0])},
    }
    shown = Result(command="test <b>", findings=[Finding(check="x", severity="bad", text="<script>")], tables=tables)
    text = page(shown)
    seen = Page()
    seen.feed(text)
    assert not seen.open and not {"script", "link", "iframe"} & seen.tags
    assert len(seen.sources) == 2 and all(s.startswith("data:image/svg+xml;base64,") for s in seen.sources)
    assert "<script>" not in text and "url(" not in text
    assert page(Result.from_json(shown.to_json())) == text
