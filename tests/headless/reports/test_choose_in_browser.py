# SPDX-License-Identifier: GPL-3.0-or-later
"""The report chooses sensors anew in headless Chromium, as the command line does."""

import csv
import shutil
import time
from dataclasses import replace

import numpy as np

from w2w.core.ranking.weights import counted_columns
from w2w.core.results_folder import StudyResults
from w2w.core.selection.constraints import Constraints
from w2w.core.selection.subsets import greedy_subset
from w2w.headless.reports.choice_data import words_of
from w2w.headless.reports.html import write_report

from .browser import find, settle, text

WISH = """
const [activities, side, forbid, must, target, most] = arguments;
const find = (name) => document.getElementById(name);
for (let button; (button = document.querySelector("#choose-wishes button"));) button.click();
document.querySelectorAll("#choose-activities input").forEach((box, at) => { box.checked = activities[at]; });
document.querySelector(`input[name=choose-side][value=${side}]`).checked = true;
find("choose-target").value = target;
find("choose-most").value = most;
for (const [kind, words] of [["forbid", forbid], ["must", must]]) for (const word of words) {
  find("choose-kind").value = kind;
  find("choose-words").value = word;
  find("choose-add").click();
}
find("choose-target").dispatchEvent(new Event("change", { bubbles: true }));
const rows = [...document.querySelectorAll("#chosen tbody tr")];
return [rows.map((row) => Number(row.querySelector("button").dataset.patch)),
  rows.map((row) => row.lastChild.textContent), find("choose-said").textContent];
"""


def random_wish(draw, words, n_activities):
    shown = draw.random(n_activities) < 0.7
    shown[draw.integers(n_activities)] = True
    side = str(draw.choice(["any", "left", "right"]))
    forbid = draw.choice(words, size=draw.integers(4), replace=False).tolist()
    must = draw.choice(words, size=draw.integers(3), replace=False).tolist()
    most = "" if draw.random() < 0.5 else int(draw.integers(1, 5))
    return shown, side, forbid, must, round(float(draw.uniform(0.5, 1.0)), 3), most


def by_our_rules(utility, patches, shown, side, forbid, must, target, most):
    other = {"any": (), "left": ("right",), "right": ("left",)}[side]
    terms = Constraints(forbid=(*other, *forbid), must=tuple(must)).terms(patches)
    return greedy_subset(utility.f1[:, shown], target, most or None, **terms)


def test_the_page_chooses_as_we_do_over_200_random_wishes(page, drawn_results):
    study = StudyResults.load(drawn_results)
    draw, met = np.random.default_rng(16), 0
    words = sorted(words_of(study.patches))
    for _ in range(200):
        wish = random_wish(draw, words, len(study.utility.activities))
        shown, *others = wish
        order, after, said = page.execute_script(WISH, shown.tolist(), *others)
        try:
            ours = by_our_rules(study.utility, study.patches, *wish)
        except ValueError:
            assert order == [], wish
            assert "must be chosen" in said or "No spot is left" in said, said
            continue
        assert tuple(order) == ours.order, (wish, said)
        np.testing.assert_allclose(np.array(after, dtype=float), ours.mean_max_after_each, atol=5.1e-4)
        assert ("not reached" in said) == (not ours.reached)
        met += 1
    assert met > 100


def test_what_the_page_chose_stands_on_the_body_and_in_a_file(page, drawn_results, tmp_path):
    page.execute_cdp_cmd("Page.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    n_activities = len(StudyResults.load(drawn_results).utility.activities)
    order, *_ = page.execute_script(WISH, [True] * n_activities, "any", ["head"], ["hand"], 1, 3)
    settle(page)
    labels = page.execute_script(
        "return [...document.querySelectorAll('#badges span')].map(s => s.textContent)"
    )
    assert [label for label in labels if label] == [str(number + 1) for number in range(len(order))]
    find(page, "#choose-csv").click()
    path = tmp_path / "sensors.csv"
    for _ in range(50):
        if path.exists():
            break
        time.sleep(0.1)
    with path.open(newline="", encoding="utf-8") as stream:
        assert [int(row["patch"]) for row in csv.DictReader(stream)] == order


def test_a_word_that_names_nothing_is_said(page):
    find(page, "#choose-words").send_keys("tail")
    find(page, "#choose-add").click()
    assert "No spot is called “tail”" in text(page, "#choose-said")


def test_the_page_weighs_the_activities_as_the_run_does(browser, drawn_results, tmp_path):
    out = shutil.copytree(drawn_results, tmp_path / "weighed")
    study = StudyResults.load(out)
    weights = np.array([0.0, 3.0, 0.5])
    replace(study.utility, weights=weights).save(out / "utility.npz")
    browser.get(write_report(out).as_uri())
    settle(browser)
    ticked = browser.execute_script(
        "return [...document.querySelectorAll('#choose-activities input')].map((box) => box.checked)"
    )
    assert ticked == [False, True, True]
    assert "background, trained against and not counted" in text(browser, "#mean-explained")
    f1 = counted_columns(study.utility.f1, weights)
    for target in (0.7, 0.9, 1.0):
        order, after, _ = browser.execute_script(WISH, ticked, "any", [], [], target, 4)
        ours = greedy_subset(f1, target, 4)
        assert tuple(order) == ours.order
        np.testing.assert_allclose(np.array(after, dtype=float), ours.mean_max_after_each, atol=5.1e-4)
    plain = greedy_subset(study.utility.f1, 1.0, 4).mean_max_after_each
    assert abs(plain[-1] - ours.mean_max_after_each[-1]) > 0.002
