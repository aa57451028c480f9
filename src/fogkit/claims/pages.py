"""The ledger as pages of the book: counts, searchable table, errata.

Every page recomputes its rows first and refuses to show one that does not carry its status.
"""

import re
from collections.abc import Mapping
from html import escape
from pathlib import Path

from fogkit.claims.ledger import STATUSES, counts, papers
from fogkit.claims.verdict import Outcome, Values, computed_text, recompute

_RICH = re.compile(r"\$(?P<math>[^$]+)\$|`(?P<code>[^`]+)`")

# The first rule takes back the light ground that the theme lays under any HTML output in dark mode.
_STYLE = """
<style>
html[data-theme=dark] .bd-content div.cell_output div.text_html:has(div.ledger) { background: none; padding: 0; }
.ledger { --ledger-line: var(--pst-color-border, #8888);
  font-size: 0.85rem; color: var(--pst-color-text-base, inherit); }
.ledger form { display: flex; flex-wrap: wrap; gap: 0.5rem; align-items: center; margin: 1rem 0; }
.ledger input, .ledger select { font: inherit; padding: 0.3rem 0.5rem; color: inherit;
  background: var(--pst-color-background, inherit); border: 1px solid var(--ledger-line); border-radius: 4px; }
.ledger input { flex: 1 1 14rem; min-width: 8rem; }
.ledger-frame { overflow: auto; max-height: 80vh; border: 1px solid var(--ledger-line); border-radius: 4px; }
.ledger table { border-collapse: collapse; margin: 0; width: 100%; color: inherit; }
.ledger .ledger-frame table.ledger-rows { table-layout: fixed; min-width: 44rem; }
.ledger-rows th:nth-child(1) { width: 19%; } .ledger-rows th:nth-child(3) { width: 35%; }
.ledger-rows th:nth-child(4) { width: 14%; }
.ledger-rows tr[hidden] { display: none; }
.ledger-print .math { font-size: 0.9em; }
.ledger-print { overflow-x: auto; overflow-y: hidden; padding-bottom: 0.2rem; }
.ledger th, .ledger td { padding: 0.4rem 0.6rem; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--ledger-line); }
.ledger thead th { position: sticky; top: 0; background: var(--pst-color-surface, #eee); }
.ledger td.number, .ledger th.number { text-align: right; }
.ledger .id, .ledger .aside { color: var(--pst-color-text-muted, inherit); font-size: 0.92em; }
.ledger .id { overflow-wrap: anywhere; }
.ledger .aside { margin-top: 0.3rem; }
.ledger .status { font-weight: 600; white-space: nowrap; border-left: 4px solid var(--status); padding-left: 0.4rem; }
.ledger .reproduced { --status: var(--pst-color-success, #28a745); }
.ledger .corrected { --status: var(--pst-color-warning, #ee9040); }
.ledger .refuted { --status: var(--pst-color-danger, #dc3545); }
.ledger .undetermined { --status: var(--pst-color-info, #276be9); }
.ledger .definition { --status: var(--pst-color-text-muted, #888); }
</style>
"""

# The form appears only when the script runs; without it the whole table stays readable. A row is searched in its source
# text (`data-text`), since MathJax replaces what stands in the cells. Several words must all occur.
_SCRIPT = """
<script>
(function (root) {
  const form = root.querySelector("form"), rows = [...root.querySelectorAll(".ledger-rows tbody tr")];
  const [text, paper, status] = form.elements, shown = root.querySelector("output");
  function filter() {
    const words = text.value.toLowerCase().split(/\\s+/).filter(Boolean);
    let visible = 0;
    for (const row of rows) {
      const keep = (!paper.value || row.dataset.paper === paper.value)
        && (!status.value || row.dataset.status === status.value)
        && words.every(word => row.dataset.text.includes(word));
      row.hidden = !keep;
      visible += keep;
    }
    shown.value = visible + " of " + rows.length + " rows";
  }
  form.hidden = false;
  form.addEventListener("input", filter);
  form.addEventListener("submit", event => event.preventDefault());
  filter();
})(document.currentScript.parentElement);
</script>
"""


def counts_markdown(paper: str | None = None, *, folder: Path | None = None) -> str:
    """The counts per paper and status as a Markdown table."""
    rows = counts(paper, folder=folder)
    head = ["paper", *STATUSES, "total"]
    body = [[key, *map(str, row.values())] for key, row in rows.items()]
    lines = [head, [":---", *["---:"] * (len(head) - 1)], *body]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def ledger_html(
    paper: str | None = None, *, folder: Path | None = None, values: Mapping[str, Values] | None = None
) -> str:
    """The counts, then every row in a table that can be filtered by words, paper and status.

    Parameters
    ----------
    paper : str, optional
        Key of the paper; all papers if not given.
    folder, values : optional
        As in `fogkit.claims.evaluate`.

    Returns
    -------
    str
        One HTML element with its own style and script, nothing loaded from elsewhere. Formulas are marked up as Sphinx
        does it for MathJax, which Sphinx loads only on pages that have a formula of their own, outside the table.

    Raises
    ------
    ValueError
        If a row does not carry its status.
    """
    keys = [paper] if paper else papers(folder)
    outcomes = [outcome for key in keys for outcome in _sound(key, folder, values)]
    body = "\n".join(_row_html(outcome) for outcome in outcomes)
    titles = ("Status and place", "Statement and note", "Print and correction", "Computed")
    head = "".join(f"<th>{title}</th>" for title in titles)
    return (
        f'<div class="ledger">{_STYLE}{_counts_html(paper, folder)}{_form_html(keys)}'
        f'<div class="ledger-frame" tabindex="0"><table class="ledger-rows"><thead><tr>{head}</tr></thead>'
        f"<tbody>\n{body}\n</tbody></table></div>{_SCRIPT}</div>"
    )


def errata_markdown(paper: str, *, folder: Path | None = None, values: Mapping[str, Values] | None = None) -> str:
    """What is wrong in the print of a paper: its corrected and refuted rows, each with what is right and why.

    Parameters
    ----------
    paper : str
        Key of the paper.
    folder, values : optional
        As in `fogkit.claims.evaluate`.

    Returns
    -------
    str
        Markdown; formulas are in dollars.

    Raises
    ------
    ValueError
        If a row of the paper does not carry its status.
    """
    wrong = [outcome for outcome in _sound(paper, folder, values) if outcome.claim.status in ("corrected", "refuted")]
    return "\n\n".join(map(_erratum, wrong)) or "No row of this paper is corrected or refuted."


def _sound(paper: str, folder: Path | None, values: Mapping[str, Values] | None) -> list[Outcome]:
    """The recomputed rows of a paper, all of which carry their status."""
    outcomes = recompute(paper, folder=folder, values=None if values is None else values[paper])
    if failed := [f"{outcome.claim.id}: {outcome.problem}" for outcome in outcomes if outcome.problem]:
        raise ValueError("rows that do not carry their status cannot be shown:\n" + "\n".join(failed))
    return outcomes


def _erratum(outcome: Outcome) -> str:
    claim = outcome.claim
    items = {
        "Print": _with_unit(claim.printed, claim.unit),
        "Correct": _with_unit(claim.corrected, claim.unit),
        "Computed": _with_unit(computed_text(outcome.computed), claim.unit) if claim.is_quantity else "",
        "Why": claim.note,
    }
    lines = [f"- *{name}:* {text}" for name, text in items.items() if text]
    return "\n".join([f"**{claim.where}: {claim.quantity}** ({claim.status}, `{claim.id}`)", "", *lines])


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}" if text and unit not in ("", "1") else text


def _rich(text: str) -> str:
    """Text with ``$formulas$`` and `` `code` `` as HTML."""
    pieces, end = [], 0
    for found in _RICH.finditer(text):
        pieces.append(escape(text[end : found.start()]))
        if found["math"]:
            pieces.append(rf'<span class="math notranslate nohighlight">\({escape(found["math"])}\)</span>')
        else:
            pieces.append(f"<code>{escape(found['code'])}</code>")
        end = found.end()
    return "".join([*pieces, escape(text[end:])])


def _row_html(outcome: Outcome) -> str:
    claim = outcome.claim
    computed = _with_unit(computed_text(outcome.computed), claim.unit)
    note = claim.note + (f" (tolerance {claim.tolerance})" if claim.tolerance else "")
    printed, corrected = _with_unit(claim.printed, claim.unit), _with_unit(claim.corrected, claim.unit)
    searched = f"{claim.id} {claim.where} {claim.quantity} {printed} {corrected} {computed} {note}".lower()
    status = f'<span class="status {claim.status}">{claim.status}</span>'
    cells = [
        f'{status}<br>{_rich(claim.where)}<br><span class="id">{escape(claim.id)}</span>',
        _rich(claim.quantity) + (f'<div class="aside">{_rich(note)}</div>' if note else ""),
        f'<div class="ledger-print">{_rich(printed)}</div>'
        + (f'<div class="aside">correct:</div><div class="ledger-print">{_rich(corrected)}</div>' if corrected else ""),
        escape(computed),
    ]
    attributes = f'id="{escape(claim.id)}" data-paper="{escape(claim.paper)}" data-status="{claim.status}"'
    return f'<tr {attributes} data-text="{escape(searched)}">' + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _counts_html(paper: str | None, folder: Path | None) -> str:
    head = "<th>Paper</th>" + "".join(f'<th class="number">{name}</th>' for name in (*STATUSES, "total"))
    body = ""
    for key, row in counts(paper, folder=folder).items():
        numbers = "".join(f'<td class="number">{number}</td>' for number in row.values())
        body += f"<tr><td>{escape(key)}</td>{numbers}</tr>"
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="ledger-frame">{table}</div>'


def _form_html(keys: list[str]) -> str:
    def choice(label: str, names: list[str] | tuple[str, ...]) -> str:
        options = "".join(f'<option value="{escape(name)}">{escape(name)}</option>' for name in names)
        return f'<select aria-label="{label}"><option value="">{label}: all</option>{options}</select>'

    return (
        '<form hidden><input type="search" aria-label="Search the ledger" placeholder="Search: equation, word, number">'
        f"{choice('paper', keys)}{choice('status', STATUSES)}<output></output></form>"
    )
