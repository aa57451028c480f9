"""A result as one HTML page with its figures in it: it opens without a network, and needs nothing beside it."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

from fogkit.cli.figures import figures
from fogkit.cli.results import Result
from fogkit.cli.summaries import rows

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; display: block; overflow-x: auto; }
td, th { padding: 0.15rem 0.8rem 0.15rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid #ddd; }
td.number { text-align: right; } img { max-width: 100%; } code { overflow-wrap: anywhere; }
.bad { color: #a00; font-weight: bold; } .doubtful { color: #960; font-weight: bold; } .good { color: #060; }
"""

MOST_ROWS = 200
"""Rows of a table that are shown; the JSON has all."""


def page(result: Result) -> str:
    """Text of the page.

    Parameters
    ----------
    result : Result
        Any result.

    Returns
    -------
    str
        HTML with style and figures inside; no script, and nothing that is loaded from elsewhere.
    """
    parts = [f"<h1>fogkit {escape(result.command)}</h1>", _verdict(result)]
    if len(result.estimates):
        header = ("quantity", "estimate", "standard deviation", "unit")
        parts += ["<h2>Estimates</h2>", _table(header, rows(result), numbers=(1, 2))]
    for caption, svg in figures(result):
        image = b64encode(svg.encode()).decode()
        parts.append(f'<h2>{escape(caption)}</h2><img alt="{escape(caption)}" src="data:image/svg+xml;base64,{image}">')
    if schedule := result.tables.get("schedule"):
        shown = [[_text(v) for v in row] for row in zip(*schedule.values(), strict=True)]
        parts += ["<h2>Schedule</h2>", _table(tuple(schedule), shown[:MOST_ROWS])]
    found = [(f.severity, f.check, f.channel, f.text) for f in result.findings]
    parts += ["<h2>Checks</h2>", _table(("verdict", "check", "channel", "what was found"), found, classes=0)]
    files = [(f["name"], f["sha256"], str(f["bytes"])) for f in result.inputs]
    if files:
        parts += ["<h2>Files</h2>", _table(("file", "SHA-256", "bytes"), files)]
    known = [(key, _text(value)) for key, value in result.parameters.items()]
    known += [(f"version of {key}", value) for key, value in result.versions.items()]
    parts += ["<h2>Parameters and versions</h2>", _table(("name", "value"), known)]
    body = "\n".join(parts)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>fogkit {escape(result.command)}</title>\n<style>{STYLE}</style></head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def _verdict(result: Result) -> str:
    count = len(result.findings)
    return f'<p>Verdict: <span class="{result.severity}">{result.severity}</span> of {count} checks.</p>'


def _table(
    header: Sequence[str], body: Iterable[Sequence[str]], numbers: Sequence[int] = (), classes: int | None = None
) -> str:
    """A table; columns of numbers to the right, and one column coloured by its own words."""
    lines = ["<table><tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in header) + "</tr>"]
    for row in body:
        cells = []
        for i, cell in enumerate(row):
            kind = "number" if i in numbers else (cell if i == classes else "")
            cells.append(f'<td class="{escape(kind)}">{escape(cell)}</td>' if kind else f"<td>{escape(cell)}</td>")
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return "\n".join([*lines, "</table>"])


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
