"""The built pages, as a reader has them: on a phone and a screen, without a network.

``NONSMOOTH_SITE`` names the folder that ``sphinx-build`` has written (.ci/run does); without it there is nothing to
look at.
"""

import os
import re
import time
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import nonsmooth as ns
from benchmarks.chromium import new_chromium

SITE = Path(os.environ.get("NONSMOOTH_SITE", "nowhere"))
PAGES = (
    "index", "quickstart", "tutorials", "how_to", "reference", "scenes", "theory/moreau_jean", "theory/scenes",
    "benchmarks/accuracy", "benchmarks/exact", "generated/api",
    "generated/api/nonsmooth.simulate", "generated/gallery/index",
    "generated/gallery/paradox/plot_sprag_slip", "generated/gallery/exact_friction/plot_arch_25",
    "questions", "choices", "how_to/other_programs", "theory/painleve", "theory/lcp", "theory/contact_solvers",
    "theory/event_driven", "tutorials/penalty", "tutorials/pile", "tutorials/cycle", "tutorials/lagrangian",
    "tutorials/scene_as_system",
)  # fmt: skip
PHONE, SCREEN = 375, 1280  # pixels
BETWEEN = 800, 1100, 1400  # tablets, and windows of which the contents of the page take a part
READY = 20.0  # s, for formulas to be set on a busy machine

pytestmark = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="NONSMOOTH_SITE names no built pages")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    try:
        opened = new_chromium(tmp_path_factory.mktemp("profile"))
    except ns.MissingExtra as reason:
        pytest.skip(f"pages are not looked at in a browser: {reason}")
    yield opened
    opened.quit()


def open_page(chromium, page, width):
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    chromium.get_log("browser")  # of the page before
    chromium.get((SITE / f"{page}.html").as_uri())
    until = time.monotonic() + READY
    typeset = (
        "return document.readyState == 'complete' && (!document.querySelector('.math') || !!window.MathJax.version)"
    )
    while not chromium.execute_script(typeset):
        assert time.monotonic() < until, f"{page} was not ready in {READY} s"
        time.sleep(0.02)
    chromium.execute_async_script(
        "const done = arguments[0]; (window.MathJax?.startup?.promise ?? Promise.resolve()).then(() => done())"
    )


@pytest.mark.parametrize("page", PAGES)
def test_no_screen_has_to_be_scrolled_sideways(chromium, page):
    for width in (PHONE, *BETWEEN):
        open_page(chromium, page, width)
        assert chromium.execute_script("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("page", PAGES)
def test_a_screen_shows_code_whole_pictures_and_formulas_and_says_no_error(chromium, page):
    open_page(chromium, page, SCREEN)
    cut = "return [...document.querySelectorAll('article pre')].filter(e => e.scrollWidth > e.clientWidth + 1)"
    assert chromium.execute_script(cut + ".map(e => e.textContent.slice(0, 60))") == []
    lazy = "document.querySelectorAll('article img').forEach(e => { e.loading = 'eager' })"
    missing = "return [...document.querySelectorAll('article img')].filter(e => e.complete && !e.naturalWidth)"
    chromium.execute_script(lazy)
    assert chromium.execute_script(missing + ".map(e => e.src)") == []
    raw = "return [...document.querySelectorAll('.math')].filter(e => !e.querySelector('mjx-container'))"
    assert chromium.execute_script(raw + ".map(e => e.textContent)") == []
    refused = "return [...document.querySelectorAll('mjx-merror')].map(e => e.dataset.mjxError || e.textContent)"
    assert chromium.execute_script(refused) == []
    assert [entry["message"] for entry in chromium.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_the_search_finds_a_name_and_shows_where_it_stands(chromium):
    open_page(chromium, "search", SCREEN)
    chromium.get((SITE / "search.html").as_uri() + "?q=indeterminate")
    until = time.monotonic() + READY
    while not chromium.execute_script("return document.querySelectorAll('#search-results li').length"):
        assert time.monotonic() < until, "the search found nothing"
        time.sleep(0.05)


def test_no_page_has_a_formula_that_mathjax_refuses_to_number():
    """Sphinx puts a formula of several lines into split, where no tag may stand: cases are parted by \\cr."""
    split = re.compile(r"\\begin\{split\}((?!\\end\{split\}).)*\\tag", re.DOTALL)
    assert [path.name for path in SITE.rglob("*.html") if split.search(path.read_text())] == []
    assert split.search(r"\begin{split}a \\ b \tag{1}\end{split}")


class Links(HTMLParser):
    """What a page links to, what it loads, and the anchors that it has."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loads, self.anchors = [], [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag in ("img", "script", "iframe") and given.get("src"):
            self.loads.append(given["src"])
        if tag == "link" and given.get("rel") == "stylesheet":
            self.loads.append(given["href"])


def pages():
    return {path: Links(path.read_text()) for path in SITE.rglob("*.html") if "_static" not in path.parts}


def test_every_link_leads_to_a_page_and_an_anchor_and_nothing_is_loaded_from_elsewhere():
    known, broken = pages(), []
    for path, page in known.items():
        for link in page.links + page.loads:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                if link in page.loads and parts.scheme != "data":
                    broken.append(f"{path.relative_to(SITE)} loads {link}")
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            has_anchor = not parts.fragment or target not in known or unquote(parts.fragment) in known[target].anchors
            if not target.exists() or not has_anchor:
                broken.append(f"{path.relative_to(SITE)} links to {link}")
    assert broken == []
