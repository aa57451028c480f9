"""The built book as a reader meets it: its files, and its pages in a browser without a network, light and dark.

Build first (`make book`), then `make pages`. Nothing here builds anything: what is missing is the reason of a skip.
Several processes share the work, each with a browser of its own; the tests of the files stay together, in one of them.
"""

import json
import pkgutil
import re
import time
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest
import yaml
from devtools import CHROMIUM, Browser

import fogkit

BOOK = Path(__file__).resolve().parents[1] / "book"
HTML = BOOK / "_build" / "html"
MADE_BY_SPHINX = {"index", "genindex", "py-modindex", "search"}

BUILT = (HTML / "searchindex.js").is_file() and (HTML / "index.html").is_file()
PAGES = sorted(p.relative_to(HTML).with_suffix("").as_posix() for p in HTML.rglob("*.html") if "_static" not in p.parts)
PAGES = [page for page in PAGES if page not in MADE_BY_SPHINX] if BUILT else ["none"]

pytestmark = pytest.mark.skipif(not BUILT, reason="the book is not built: `make book` first")
in_browser = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed (Debian: apt-get install chromium)")
each_page = pytest.mark.parametrize("page", PAGES)
of_files = pytest.mark.xdist_group("files")


# The files: no browser needed


LOADING = {"script", "img", "iframe", "source", "video", "audio", "embed"}
NEVER_CLOSED = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
NOT_LOADED = {"index", "search", "next", "prev", "canonical"}
MATHS = {"math", "text_html"}  # where MathJax looks for equations
SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)
ELSEWHERE = re.compile(r"([a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
LEFT_MARKUP = re.compile(
    r"\{(?:glue|eq|ref|numref|cite|doc|math|func|class|mod)\b[^}]*\}|\$\$|\$[^$\s][^$]*\$|\\[(\[]|:::|```|\[\d+\]_"
)


class Page(HTMLParser):
    """What a page links to, what it loads, its anchors, and its prose (without code and equations)."""

    def __init__(self, path: Path):
        super().__init__()
        self.links, self.loads, self.anchors, self.prose, self._stack = [], [], set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.anchors.update({attrs.get("id"), attrs.get("name")} - {None})
        if tag == "a" and attrs.get("href"):
            self.links.append(attrs["href"])
        if tag in LOADING and attrs.get("src"):
            self.loads.append(attrs["src"])
        if tag == "link" and not NOT_LOADED & set(attrs.get("rel", "").split()):
            self.loads.append(attrs["href"])
        if tag not in NEVER_CLOSED:
            source = tag in {"script", "style", "pre", "code"} or MATHS & set((attrs.get("class") or "").split())
            self._stack.append((tag, source, tag == "article"))

    def handle_endtag(self, tag):
        if any(tag == opened for opened, *_ in self._stack):  # a stray end tag closes nothing
            while self._stack.pop()[0] != tag:
                pass

    def handle_data(self, data):
        if any(article for *_, article in self._stack) and not any(source for _, source, _ in self._stack):
            self.prose.append(data)


@pytest.fixture(scope="module")
def pages():
    """All pages, read once: ``{name: Page}``."""
    files = {page: HTML / f"{page}.html" for page in [*PAGES, *MADE_BY_SPHINX]}
    return {page: Page(path) for page, path in files.items() if path.is_file()}


def toc_pages() -> list[str]:
    toc = yaml.safe_load((BOOK / "_toc.yml").read_text(encoding="utf-8"))
    return [toc["root"], *(chapter["file"] for part in toc["parts"] for chapter in part["chapters"])]


def target(page: str, link: str) -> tuple[Path, str]:
    """File and anchor that a link on a page leads to."""
    path, anchor = urldefrag(link)
    path = unquote(path.partition("?")[0])
    here = HTML / f"{page}.html"
    return ((here.parent / path).resolve() if path else here), unquote(anchor)


def page_at(path: Path) -> str:
    return path.relative_to(HTML).with_suffix("").as_posix()


@of_files
def test_nothing_is_loaded_from_elsewhere(pages):
    assert [(name, url) for name, page in pages.items() for url in page.loads if ELSEWHERE.match(url)] == []
    for sheet in HTML.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet


@of_files
def test_every_file_that_a_page_loads_is_there(pages):
    loads = [(name, url) for name, page in pages.items() for url in page.loads if not url.startswith("data:")]
    assert [(name, url) for name, url in loads if not target(name, url)[0].is_file()] == []


@of_files
def test_every_link_inside_the_book_leads_somewhere(pages):
    dead = []
    for name, page in pages.items():
        for link in page.links:
            if SCHEME.match(link):
                continue
            path, anchor = target(name, link)
            if path.suffix == ".html" and path.is_file() and anchor:
                known = pages[page_at(path)].anchors
                dead += [] if anchor in known else [(name, link)]
            elif not path.is_file():
                dead.append((name, link))
    assert dead == []


@of_files
def test_every_page_of_the_contents_is_built_and_every_built_page_is_reached(pages):
    assert set(toc_pages()) <= set(PAGES)
    reached, new = set(), {"index", toc_pages()[0]}
    while new:
        reached |= new
        found = {target(name, link)[0] for name in new for link in pages[name].links if not SCHEME.match(link)}
        new = {page_at(path) for path in found if path.suffix == ".html"} & set(pages) - reached
    assert set(PAGES) - reached == set()


@of_files
def test_every_public_module_has_a_page():
    names = ["fogkit", *(m.name for m in pkgutil.walk_packages(fogkit.__path__, "fogkit."))]
    public = {name for name in names if not any(part.startswith("_") for part in name.split("."))}
    assert {f"api/{name}" for name in public} - set(PAGES) == set()


@of_files
def test_the_search_index_covers_every_page():
    text = (HTML / "searchindex.js").read_text(encoding="utf-8")
    index = json.loads(text[text.index("(") + 1 : text.rindex(")")])
    assert set(index["docnames"]) == set(PAGES)
    assert "gyro" in index["terms"]


@of_files
@each_page
def test_no_markup_is_left_in_the_prose(pages, page):
    assert LEFT_MARKUP.findall(" ".join(pages[page].prose)) == []


# The pages in a browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.close()


def address(page: str) -> str:
    return (HTML / f"{page}.html").as_uri()


# Texts of the article with too little contrast to what is behind them: WCAG's ratio, 3 being its least for large text.
FAINT_TEXT = """(() => {
  const rgba = s => (s.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const linear = v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const luminance = c => [0.2126, 0.7152, 0.0722].reduce((sum, weight, i) => sum + weight * linear(c[i] / 255), 0);
  const behind = e => {
    for (; e; e = e.parentElement) {
      const c = rgba(getComputedStyle(e).backgroundColor);
      if (c.length < 4 || c[3] > 0.5) return c;
    }
    return [255, 255, 255];
  };
  const faint = [];
  for (const e of document.querySelectorAll("article *")) {
    if (![...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()) || !e.checkVisibility()) continue;
    if (e.closest(".headerlink, mjx-assistive-mml, button, style, script, svg")) continue;
    const [a, b] = [luminance(rgba(getComputedStyle(e).color)), luminance(behind(e))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 3) faint.push(`${e.tagName}.${e.className}, ${ratio.toFixed(2)}: ${e.textContent.trim().slice(0, 40)}`);
  }
  return faint;
})()"""

# The text that a reader sees, without code.
PROSE = """(() => {
  const article = document.querySelector("article").cloneNode(true);
  article.querySelectorAll("pre, code, script, style, mjx-container").forEach(e => e.remove());
  return article.textContent;
})()"""

# What makes the page wider than its window: what reaches beyond it and does not scroll in a box of its own.
TOO_WIDE = """(() => {
  if (document.documentElement.scrollWidth <= innerWidth + 1) return [];
  const scrolls = e => ["auto", "scroll", "hidden"].includes(getComputedStyle(e).overflowX);
  const inBox = e => { while ((e = e.parentElement) && e.tagName !== "ARTICLE") if (scrolls(e)) return true; };
  const wide = [...document.querySelectorAll("article *")]
    .filter(e => e.checkVisibility() && e.getBoundingClientRect().right > innerWidth + 1 && !inBox(e))
    .map(e => `${e.tagName}.${e.className}: ${e.textContent.trim().slice(0, 40)}`);
  return [`${document.documentElement.scrollWidth} px`, ...wide.slice(-5)];
})()"""

WIDE_EQUATIONS = """[...document.querySelectorAll("article div.math mjx-container")]
  .filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.parentElement.textContent.trim().slice(0, 40))"""

UNDRAWN = """[...document.querySelectorAll(".math")].filter(e => !e.querySelector("mjx-container"))
  .map(e => e.textContent.trim().slice(0, 40))"""

MATHS_ERRORS = "[...document.querySelectorAll('mjx-merror, [data-mjx-error]')].map(e => e.textContent)"
MISSING_IMAGES = "[...document.images].filter(i => !(i.complete && i.naturalWidth)).map(i => i.src)"

# Figures are drawn in dark ink on white.
SHEETS_NOT_WHITE = """[...document.querySelectorAll("article .cell_output img")]
  .map(image => getComputedStyle(image).backgroundColor).filter(colour => colour !== "rgb(255, 255, 255)")"""

# Each solution that hides, clicked: does it grow?
SOLUTIONS_THAT_STAY_SHUT = """[...document.querySelectorAll(".admonition.dropdown")].filter(box => {
  const height = box.offsetHeight; box.querySelector(".toggle-button").click(); return box.offsetHeight <= height;
}).map(box => box.textContent.trim().slice(0, 40))"""

ANYHOW = {
    "equations shown as their source": UNDRAWN,
    "errors of MathJax": MATHS_ERRORS,
    "images that did not load": MISSING_IMAGES,
    "equations wider than their line": WIDE_EQUATIONS,
}


def faults(browser, checks: dict[str, str], when: str) -> list[tuple]:
    """What was found of each kind, with the state of the window."""
    return [(when, kind, found) for kind, script in checks.items() if (found := browser.evaluate(script))]


@in_browser
@each_page
def test_page_in_browser(browser, page):
    """Opened once: light, then dark, then in a narrow window, then with its solutions open."""
    browser.open(address(page), "light")
    found = faults(browser, ANYHOW, "light")
    found += [("light", "markup in the prose", left) for left in LEFT_MARKUP.findall(browser.evaluate(PROSE))]
    for scheme in ("light", "dark"):
        browser.show(scheme)
        assert browser.evaluate("document.documentElement.dataset.theme") == scheme
        found += faults(browser, {"faint text": FAINT_TEXT, "too wide": TOO_WIDE}, scheme)
    found += faults(browser, {"figures without a white sheet": SHEETS_NOT_WHITE}, "dark")
    browser.show("light", width=600)
    found += faults(browser, {"too wide": TOO_WIDE}, "600 px")
    browser.show("light")
    found += faults(browser, {"solutions that do not open": SOLUTIONS_THAT_STAY_SHUT}, "light")
    found += [("console", complaint) for complaint in browser.complaints()]
    assert not found, "\n".join(map(str, ["", *found]))


@in_browser
def test_search_finds_pages_without_a_network(browser):
    browser.open(address("search") + "?q=gyro")
    for _ in range(100):
        if browser.evaluate("document.querySelectorAll('#search-results li a').length") > 2:
            break
        time.sleep(0.1)
    links = browser.evaluate("[...document.querySelectorAll('#search-results li a')].map(a => a.href)")
    assert len(links) > 2
    assert all(Path(unquote(urldefrag(link)[0].removeprefix("file://"))).is_file() for link in links)
    assert browser.complaints() == []


@in_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_opens_in_the_scheme_of_the_reader(browser, scheme):
    browser.open(address(toc_pages()[0]), scheme)
    assert browser.evaluate("document.documentElement.dataset.theme") == scheme
    assert browser.complaints() == []


@in_browser
def test_the_reader_can_change_light_and_dark(browser):
    browser.open(address(toc_pages()[0]), "light")
    seen = set()
    for _ in range(3):
        browser.evaluate("document.querySelector('.theme-switch-button').click()")
        seen.add(browser.evaluate("document.documentElement.dataset.theme"))
    browser.evaluate("localStorage.clear()")  # the choice is kept, and would be that of the pages opened after this one
    assert seen == {"light", "dark"}
    assert browser.complaints() == []
