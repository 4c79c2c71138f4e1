# SPDX-License-Identifier: GPL-3.0-or-later
"""The report in headless Chromium: it draws, answers mouse and keyboard, and asks nothing of the network."""

import base64
import io
import json
import re
from pathlib import Path

import axe_core_python
import numpy as np
import pypdfium2 as pdfium
import pytest
from matplotlib.image import imread
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.colours import score_range
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.study.choosing import compare_places
from w2w.core.study.results import StudyResults
from w2w.headless.commands.report import write_report
from w2w.report.page import report_page, still_picture

from .browser import find, settle, text


def picture(browser):
    """The canvas as it is drawn, RGBA."""
    encoded = browser.execute_script(
        "return document.getElementById('view').toDataURL('image/png').split(',')[1]"
    )
    return imread(io.BytesIO(base64.b64decode(encoded)))


def choose(browser, name, value):
    find(browser, f"input[name={name}][value='{value}']").click()
    settle(browser)


def place_on_screen(browser, drawn_results, name):
    """Where the front view shows a vertex, by reckoning it here: fractions of the canvas."""
    body, patches = (
        Body.load(drawn_results / ".w2w" / "body.npz"),
        PatchSet.load(drawn_results / ".w2w" / "patches.npz"),
    )
    width, height = browser.execute_script(
        "const c = document.getElementById('view'); return [c.clientWidth, c.clientHeight]"
    )
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    size, field = high - low, np.tan(np.radians(14))
    half = max(size[2] / 2, max(size[:2]) / 2 / (width / height)) * 1.06
    distance = half / field + size[1] / 2
    turn = Rotation.from_euler("x", 0.06).as_matrix()  # the eye stands a little high
    seen = turn @ (body.vertices[patches.vertices[patches.names.index(name)]] - (low + high) / 2)
    depth = distance + seen[1]
    return seen[0] / depth / field * height / 2, seen[2] / depth / field * height / 2


def hover(browser, right, up):
    """Point at a place of the canvas, pixels from its middle."""
    from selenium.webdriver import ActionChains

    canvas = find(browser, "#view")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", canvas)
    ActionChains(browser).move_to_element_with_offset(canvas, round(right), round(-up)).perform()
    settle(browser)


def test_the_body_is_drawn_in_the_scale_s_colours(page):
    image = picture(page)
    drawn = image[image[..., 3] > 0.9]
    assert 0.05 < len(drawn) / image[..., 3].size < 0.6
    assert drawn[:, :3].std(axis=0).max() > 0.08
    assert not find(page, ".stage .still").is_displayed()


def test_another_activity_has_other_colours_and_its_own_scale(page, drawn_results):
    utility = UtilityMap.load(drawn_results / "utility.npz")
    mean, low = picture(page), text(page, "#bar-low")
    assert low == f"{score_range(utility.expected_mean)[0]:.2f}"
    number = utility.activities.index("arm_raise")
    choose(page, "map", number + 1)
    assert np.abs(picture(page)[..., :3] - mean[..., :3]).max() > 0.2
    scores = utility.expected_f1[:, number]
    ends = [float(text(page, bar)) for bar in ("#bar-low", "#bar-high")]
    np.testing.assert_allclose(ends, score_range(scores), atol=0.0051)
    assert text(page, "#ranked-title") == "Arm raise"
    patches = PatchSet.load(drawn_results / ".w2w" / "patches.npz")
    first = find(page, "#ranked tbody tr").text
    assert patches.names[int(scores.argmax())] in first
    assert any(f"{scores.max() + nudge:.2f}" in first for nudge in (-1e-5, 1e-5))  # .875 is either


def test_the_scores_of_these_very_clips_can_be_seen_too(page, drawn_results):
    utility = UtilityMap.load(drawn_results / "utility.npz")
    assert text(page, ".unit") == "Expected F1"
    expected, first = picture(page), text(page, "#ranked tbody tr")
    choose(page, "scores", "raw")
    ends = [float(text(page, bar)) for bar in ("#bar-low", "#bar-high")]
    np.testing.assert_allclose(ends, score_range(utility.mean), atol=0.0051)
    assert text(page, ".unit") == "F1 on these clips"
    assert np.abs(picture(page)[..., :3] - expected[..., :3]).max() > 0.1
    assert text(page, "#ranked tbody tr") == first  # the best stays the best


def test_one_range_for_all_maps(page, drawn_results):
    utility = UtilityMap.load(drawn_results / "utility.npz")
    everything = np.column_stack([utility.expected_mean, utility.expected_f1])
    before = picture(page)
    choose(page, "range", "same")
    low, high = score_range(everything)
    assert (text(page, "#bar-low"), text(page, "#bar-high")) == (f"{low:.2f}", f"{high:.2f}")
    assert np.abs(picture(page) - before).max() > 0.05


def test_pointing_at_a_place_reads_it(page, drawn_results):
    utility = UtilityMap.load(drawn_results / "utility.npz")
    patches = PatchSet.load(drawn_results / ".w2w" / "patches.npz")
    body = Body.load(drawn_results / ".w2w" / "body.npz")
    front = np.flatnonzero(body.vertex_normals[patches.vertices][:, 1] < -0.85)
    assert len(front) > 3
    for patch in front[:4].tolist():
        hover(page, *place_on_screen(page, drawn_results, patches.names[patch]))
        assert find(page, "#tip").is_displayed()
        told = text(page, "#tip")
        assert patches.names[patch] in told
        assert f"expected F1 {utility.expected_mean[patch]:.2f}" in told
        assert f"interval {utility.expected_low[patch]:.2f}–{utility.expected_high[patch]:.2f}" in told
        raw = f"{utility.mean[patch]:.2f} ({utility.mean_low[patch]:.2f}–{utility.mean_high[patch]:.2f})"
        assert f"on these clips {raw}" in told
        assert told.startswith(text(page, "#readout b"))
    hover(page, -300, 280)
    assert not find(page, "#tip").is_displayed()


def test_it_turns_by_mouse_keyboard_and_buttons(page):
    from selenium.webdriver import ActionChains, Keys

    canvas, front = find(page, "#view"), picture(page)
    ActionChains(page).drag_and_drop_by_offset(canvas, 150, 0).perform()
    settle(page)
    dragged = picture(page)
    assert np.abs(dragged - front).mean() > 0.02
    canvas.send_keys(Keys.HOME)
    settle(page)
    np.testing.assert_array_equal(picture(page), front)
    canvas.send_keys(Keys.ARROW_LEFT)
    settle(page)
    assert np.abs(picture(page) - front).mean() > 0.005
    canvas.send_keys(Keys.HOME, "+")
    settle(page)
    closer = picture(page)
    assert (closer[..., 3] > 0.9).sum() > (front[..., 3] > 0.9).sum()
    canvas.send_keys(Keys.HOME)
    find(page, "[data-turn='180']").click()
    settle(page)
    back = picture(page)
    # from behind, the outline is the front's mirrored, about
    outline = (front[..., 3] > 0.5)[:, ::-1] != (back[..., 3] > 0.5)
    assert outline.mean() < 0.02
    names = [button.text for button in page.find_elements("css selector", "#ranked tbody button")]
    pointed_at = text(page, "#readout b")
    canvas.send_keys("n")
    settle(page)
    following = names.index(pointed_at) + 1 if pointed_at in names else 0
    assert text(page, "#readout b") == names[following % len(names)]


def test_the_body_is_named_and_worked_without_a_mouse(page):
    from selenium.webdriver import ActionChains, Keys

    canvas = find(page, "#view")
    for _ in range(12):  # the link to the tables, products, sets and the words to compare, then the body
        ActionChains(page).send_keys(Keys.TAB).perform()
        if page.switch_to.active_element == canvas:
            break
    assert page.switch_to.active_element == canvas
    assert canvas.aria_role == "application"
    assert canvas.accessible_name.startswith(
        "The body in 3D, coloured by expected F1 of All activities (mean)"
    )
    assert canvas.get_attribute("aria-roledescription") == "3D view"
    keys = find(page, f"#{canvas.get_attribute('aria-describedby')}").text
    assert "arrow keys" in keys
    front = picture(page)
    for _ in range(7):
        ActionChains(page).send_keys(Keys.ARROW_LEFT).perform()
    settle(page)
    assert np.abs(picture(page) - front).mean() > 0.01
    page.execute_async_script("setTimeout(arguments[0], 350)")
    assert text(page, "#seen") == "Seen from the front left"
    assert find(page, "#seen").aria_role == "status"
    find(page, "[data-turn='180']").click()
    page.execute_async_script("setTimeout(arguments[0], 350)")
    assert text(page, "#seen") == "Seen from the back"


def test_an_activity_of_two_clips_shows_a_caution_for_its_interval_and_the_means(page, sparse_results):
    assert "too few" not in text(page, "#ranked")
    page.get(write_report(sparse_results).as_uri())
    settle(page)
    caution = "from 2 clips only: too few for an interval"
    assert "too few clips" in text(page, "#ranked tbody tr")
    titles = [label.text for label in page.find_elements("css selector", "#maps label")]
    choose(page, "map", titles.index("Jump"))
    assert "too few clips" in text(page, "#ranked tbody tr")
    assert caution in text(page, "#readout")
    assert text(page, ".kind") == "Smart <b>shirt</b> · where to wear"


def test_a_place_in_a_table_turns_the_body_to_it(page):
    button = find(page, "#tables button.go[data-map]")
    name = button.text
    page.execute_script("arguments[0].click()", button)
    settle(page)
    assert text(page, "#readout b") == name
    assert page.execute_script("return document.querySelector('input[name=map]:checked').value") == "1"


def test_labels_that_are_markup_stay_text(page, drawn_results):
    hostile = UtilityMap.load(drawn_results / "utility.npz").activities[0]
    assert "<script>" in hostile
    shown = [label.text for label in page.find_elements("css selector", "#maps label")]
    assert hostile in shown
    choose(page, "map", 1)
    assert text(page, "#ranked-title") == " ".join(hostile.split())
    assert page.execute_script("return document.scripts.length") == 3
    assert page.execute_script("return document.images.length") == 0


def printed(browser):
    """The first page as it is printed, without backgrounds, as a browser does by itself, RGB."""
    made = browser.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})["data"]
    return pdfium.PdfDocument(base64.b64decode(made))[0].render(scale=3).to_numpy()[..., :3] / 255.0


@pytest.mark.parametrize("width", [640, 1280, 2000])
def test_print_has_the_discs_on_the_body_whatever_the_window_s_size(browser, drawn_results, tmp_path, width):
    patches = PatchSet.load(drawn_results / ".w2w" / "patches.npz")
    summary = json.loads((drawn_results / "summary.json").read_text())
    shown = [product["patch"] for product in summary["answer"]["products"][:3]]
    report = write_report(drawn_results).read_text(encoding="utf-8")
    body = Body.load(drawn_results / ".w2w" / "body.npz")
    outermost = int(body.vertices[patches.vertices][:, 0].argmax())
    assert outermost not in shown  # a finger's tip, whose place on paper is known from the outline alone
    x, y = still_picture(StudyResults.load(drawn_results), body, [outermost], [])["first"][0][:2]
    browser.set_window_size(width, 1000)
    pictures = []
    for disc in ("", f'<circle cx="{x}" cy="{y}" r="20"/>'):
        page = tmp_path / "report.html"
        first = re.sub(r'(<svg class="still".*?/>).*?(</svg>)', rf"\1{disc}\2", report, count=1, flags=re.S)
        page.write_text(first, encoding="utf-8")
        browser.get(page.as_uri())
        settle(browser)
        pictures.append(printed(browser))
    plain, marked = pictures
    at = np.argwhere(np.abs(marked - plain).max(axis=2) > 0.3)
    body_here = np.ptp(plain, axis=2) > 0.25  # the scale's colours; the words are grey
    body_here[:, : plain.shape[1] // 2] = False
    body_here[at[:, 0].max() + 3 * np.ptp(at[:, 0]) :] = False
    side = np.nonzero(body_here)[1]
    tip = side.max() if at[:, 1].mean() > (side.min() + side.max()) / 2 else side.min()
    reach = np.ptp(at[:, 1])
    middle = (side.min() + side.max()) / 2
    assert min(abs(at[:, 1].mean() - edge) for edge in (tip, middle)) < reach


def test_without_graphics_front_and_back_stand_still(page):
    page.execute_script(
        "document.getElementById('view').getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()"
    )
    settle(page)
    assert find(page, ".stage .still").is_displayed()
    assert not find(page, "#view").is_displayed()
    assert len(page.find_elements("css selector", ".stage .still circle")) == 3
    assert not page.find_elements("css selector", "#badges span")


def test_it_opens_on_the_side_of_the_recommended_spot(browser, drawn_results):
    browser.get(write_report(drawn_results).as_uri())
    settle(browser)
    hidden = browser.find_element("css selector", "#badges span").get_attribute("class")
    assert "hidden" not in hidden


def test_products_and_regions_are_compared_by_name(page, drawn_results):
    find(page, "#places").send_keys("Smart  watch, pendant, tail")
    find(page, "#compare button").click()
    lines = [line.text for line in page.find_elements("css selector", "#compared li")]
    assert {line.partition(":")[0] for line in lines} == {"smart watch", "pendant", "tail"}
    assert lines[-1].startswith("tail: nothing is called that; try watch, trouser pocket")
    study = StudyResults.load(drawn_results)
    best = compare_places(study, ["smart watch"])[0]
    told = next(line for line in lines if line.startswith("smart watch"))
    assert f"F1 {study.utility.expected_mean[best.patch]:.2f} (" in told


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_axe_finds_nothing(page, scheme, width):
    """WCAG 2.1 AA and best practice, by axe-core."""
    script = Path(axe_core_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    try:
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        page.execute_script("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        page.execute_script(script)
        found = page.execute_async_script(
            "axe.run().then((r) => arguments[0](r.violations.map((v) => [v.id, v.nodes[0].html])))"
        )
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert found == []


def test_no_request_leaves_the_page(page):
    requests = [
        message["params"]["request"]["url"]
        for entry in page.get_log("performance")
        if (message := json.loads(entry["message"])["message"])["method"] == "Network.requestWillBeSent"
        and message["params"]["documentURL"].startswith("file:")  # Chromium's own pages ask for theirs
    ]
    assert requests
    assert all(url.startswith(("file:", "data:")) for url in requests), requests
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_on_a_phone_nothing_is_wider_than_the_screen(page):
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 390, "height": 800, "deviceScaleFactor": 2, "mobile": True},
    )
    try:
        settle(page)
        assert page.execute_script("return document.documentElement.scrollWidth") <= 390
        assert picture(page).shape[1] >= 600  # drawn at the screen's own resolution
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_on_a_phone_the_products_come_before_the_cautions(browser, sparse_results, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(report_page(StudyResults.load(sparse_results)), encoding="utf-8")
    size = {"width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": True}
    try:
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(path.as_uri())
        settle(browser)
        tops = "return ['.choices', '#cautions'].map((css) => document.querySelector(css).offsetTop)"
        products, cautions = browser.execute_script(tops)
        assert products < cautions
        assert text(browser, ".warning, .note a").startswith("What ")  # the way to them stands at the top
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_every_control_has_a_name_and_text_stands_out(page):
    """The accessible name of every control, and contrast of text against its ground (WCAG 2.2 AA)."""
    nameless = page.execute_script(
        "return [...document.querySelectorAll('button, canvas, input, fieldset')].filter(e =>"
        " !(e.getAttribute('aria-label') || e.textContent.trim() || (e.labels && e.labels.length)))"
        ".map(e => e.outerHTML)"
    )
    assert not nameless
    pairs = page.execute_script(
        "const back = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor;"
        " if (!c.startsWith('rgba(0, 0, 0, 0')) return c; } return 'rgb(255, 255, 255)'; };"
        "return [...document.querySelectorAll('p, td, th, label span, button, .unit, caption, li, legend')]"
        ".map(e => [e.textContent.slice(0, 20), getComputedStyle(e).color, back(e)]);"
    )
    for words, ink, ground in pairs:
        assert contrast(colour(ink), colour(ground)) >= 4.5, (words, ink, ground)


def colour(css):
    return np.array([float(part) for part in css.strip("rgba()").split(",")[:3]]) / 255


def contrast(one, other):
    def luminance(rgb):
        return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) @ [
            0.2126,
            0.7152,
            0.0722,
        ]

    light, dark = sorted([luminance(one), luminance(other)], reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_the_sites_search_runs_from_a_folder(browser, tmp_path):
    """Browsers start no worker there; the site's own stand-in answers in a hidden frame, without network."""
    shim = Path(__file__).resolve().parents[2] / "docs" / "iframe-worker.js"
    assert f"polyfills: [{shim.name}]" in (shim.parents[1] / "mkdocs.yml").read_text("utf-8")
    (tmp_path / "double.js").write_text("self.addEventListener('message', e => postMessage(2 * e.data))")
    page = tmp_path / "page.html"
    page.write_text(f'<!doctype html><body><script src="{shim.as_uri()}"></script>')
    browser.get(page.as_uri())
    ask = "const w = new Worker('double.js'); w.addEventListener('message', e => arguments[0](e.data));"
    assert browser.execute_async_script(f"{ask} w.postMessage(21);") == 42


def test_the_answer_is_saved_as_a_picture_for_a_slide(page):
    page.execute_script("HTMLAnchorElement.prototype.click = function () { window.saved = this.href; }")
    find(page, "#save").click()
    settle(page)
    saved = page.execute_async_script(
        "const done = arguments[0], wait = () => (window.saved ? done(window.saved) : setTimeout(wait, 50));"
        "wait()"
    )
    shown = imread(io.BytesIO(base64.b64decode(saved.split(",")[1])))[..., :3]
    assert shown.shape == (1080, 1920, 3)
    told, body = shown[:, :950], shown[60:920, 980:1860]
    assert (told.min(axis=2) < 0.3).mean() > 0.01  # words
    assert ((body.max(axis=2) - body.min(axis=2)) > 0.2).mean() > 0.05  # the body's colours


def test_paper_has_the_legend_and_shows_what_is_folded(page):
    made = page.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})["data"]
    pages = pdfium.PdfDocument(base64.b64decode(made))
    words = [sheet.get_textpage().get_text_bounded() for sheet in pages]
    assert "Expected F1" in words[0]
    assert "Activity by activity" in words[1]  # the answer has a page of its own
    assert "costs up to .02 is as good" in " ".join(words[0].split())  # and no more than one
    assert any("Everything here is simulated" in part for part in words)
    assert not page.find_elements("css selector", ".folded details[open]")


def test_a_phone_has_the_legend(page):
    page.set_window_size(420, 900)
    settle(page)
    assert find(page, ".unit").is_displayed()
