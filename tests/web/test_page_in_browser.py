# SPDX-License-Identifier: GPL-3.0-or-later
"""The app's page in headless Chromium: clips go up, labels are edited, the answer's report is alive."""

import base64
import re
import shutil
import threading
import time
from html import escape
from pathlib import Path

import axe_core_python
import pypdfium2 as pdfium
import pytest
import uvicorn
from starlette.responses import JSONResponse, StreamingResponse

from w2w.core.files import write_json, write_text
from w2w.core.imu.recordings import Recordings
from w2w.headless.commands.report import write_report
from w2w.web.answers import Answers
from w2w.web.app import web_app
from w2w.web.choosing import pilot_by, report_again, report_needing
from w2w.web.guard import Doors
from w2w.web.study import EVENTS, INPUT, Study
from w2w.web.uploads import RefusedError
from w2w.web.work import Work

from ..headless.conftest import made_once_here, one_worker, write_motions
from ..patience import HANG_S
from ..phone_exports import G, motion, table
from ..report.browser import find, settle, text
from ..report.conftest import browser, drawn, drawn_results

__all__ = ["browser", "drawn", "drawn_results", "made_once_here", "one_worker"]


@pytest.fixture
def server(tmp_path):
    """An app that serves, its address and its data folder."""
    data = tmp_path / "data"
    data.mkdir()
    app = web_app(Work(data, 1, "", 30.0), Doors("127.0.0.1", (), (), 10**8))
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_level="warning", timeout_graceful_shutdown=1))
    thread = threading.Thread(target=server.run)
    thread.start()
    wait(lambda: server.started)
    yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}", data / "local"
    server.should_exit = True
    thread.join(HANG_S)


@pytest.fixture
def quiet(browser, server):  # noqa: ARG001
    """The browser; at the end, while the server still serves, nothing was refused by the policy or failed."""
    browser.get_log("browser")
    yield browser
    browser.get("about:blank")
    loud = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    assert not loud, loud


def wait(until):
    end = time.monotonic() + HANG_S
    while not (found := until()):
        assert time.monotonic() < end
        time.sleep(0.05)
    return found


def finished(owner, results) -> Study:
    """A study whose run has ended, with these results."""
    study = Study.make(owner)
    shutil.copytree(results, study.results)
    write_report(study.results)
    write_motions(study.folder / INPUT, {"slow": 0.5, "fast": 2.0}, 2)
    files = {clip.file: clip.file for clip in study.library().clips}
    judged = {file: {"problem": "it is damaged"} for file in files}
    write_json(
        study.folder / "request.json", study.request() | {"files": files, "judged": judged, "asked": 1.0}
    )
    write_text(study.folder / EVENTS, '{"event": "finished", "exit_code": 0}\n')
    return study


def test_a_folder_goes_up_and_its_labels_are_edited(quiet, server, tmp_path):
    address, owner = server
    write_motions(tmp_path / "LIB", {"slow": 0.5, "fast": 2.0}, 2)
    quiet.get(address)
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    find(quiet, "#folder").send_keys(str(tmp_path / "LIB"))
    wait(lambda: text(quiet, "#uploading") == "4 of 4 files sent.")
    wait(lambda: text(quiet, "#clips").count("5.0 s at 30 frames/s") == 4)
    assert "fast/fast_0.npz" in text(quiet, "#clips")
    (study,) = (Study(folder) for folder in owner.iterdir())
    assert quiet.current_url == f"{address}/studies/{study.id}"

    rename = find(quiet, "#activities input")
    quiet.execute_script(
        "arguments[0].value = 'dash'; arguments[0].dispatchEvent(new Event('change'))", rename
    )
    settle(quiet)
    quiet.execute_script("document.querySelectorAll('#clips input[type=checkbox]')[3].click()")
    quiet.execute_script(
        "fetch = ((real) => (path, ...more) => path.endsWith('/run') ? 0 : real(path, ...more))(fetch)"
    )
    find(quiet, "#run").click()
    wait(lambda: (study.folder / "labels.csv").exists())
    labels = {(row["file"], row.get("activity")) for row in study.table()[0]}
    assert {label for _, label in labels} == {"dash", "slow", None}
    assert ("slow/slow_1.npz", None) in labels


def drop(browser, *paths):
    """A drag from a file manager, as the browser itself sees it."""
    zone = find(browser, "#zone").rect
    dragged = {
        "x": zone["x"] + zone["width"] / 2,
        "y": zone["y"] + zone["height"] / 2,
        "data": {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1},
    }
    for kind in ("dragEnter", "dragOver"):
        browser.execute_cdp_cmd("Input.dispatchDragEvent", {"type": kind, **dragged})
    assert "over" in find(browser, "#zone").get_attribute("class")
    browser.execute_cdp_cmd("Input.dispatchDragEvent", {"type": "drop", **dragged})


def test_folders_are_dropped_on_the_page(quiet, server, tmp_path):
    address, owner = server
    write_motions(tmp_path, {"slow": 0.5, "fast": 2.0}, 1)
    quiet.get(address)
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    drop(quiet, tmp_path / "slow", tmp_path / "fast")
    wait(lambda: text(quiet, "#uploading") == "2 of 2 files sent.")
    assert "over" not in find(quiet, "#zone").get_attribute("class")
    wait(lambda: text(quiet, "#clips").count("5.0 s at 30 frames/s") == 2)
    (study,) = (Study(folder) for folder in owner.iterdir())
    assert {row["activity"] for row in study.table()[0]} == {"slow", "fast"}


def test_a_file_that_replaces_another_is_said(quiet, server, tmp_path):
    write_motions(tmp_path, {"slow": 0.5, "fast": 2.0}, 1)
    loose = [path.rename(path.with_name("take.npz")) for path in tmp_path.glob("*/*.npz")]
    quiet.get(server[0])
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    for path, said in [(loose[0], ""), (loose[0], ""), (loose[1], "it replaced another file of that name")]:
        quiet.execute_script("document.querySelector('#uploading').textContent = ''")
        drop(quiet, path)
        wait(lambda: text(quiet, "#uploading") == "1 of 1 files sent.")
        wait(lambda said=said: said in text(quiet, "#refused"))
        assert bool(text(quiet, "#refused")) == bool(said)


def test_the_report_is_alive_under_the_strict_policy(quiet, server, drawn_results):
    address, owner = server
    study = finished(owner, drawn_results)
    quiet.get(f"{address}/studies/{study.id}")
    frame = find(quiet, "#report")
    wait(lambda: frame.get_attribute("src"))
    assert study.answer() in quiet.title
    quiet.switch_to.frame(frame)
    wait(lambda: quiet.find_elements("css selector", ".stage.live"))
    assert text(quiet, "h1") == study.answer()
    assert quiet.execute_script("return document.querySelectorAll('#ranked tbody tr').length") > 3
    quiet.switch_to.default_content()


def typed(browser, css, value, number=0):
    """Types into a field as a person does: the page hears of it when the field is left."""
    browser.execute_script(
        "const field = document.querySelectorAll(arguments[0])[arguments[2]];"
        "if (field.type === 'checkbox') field.checked = arguments[1]; else field.value = arguments[1];"
        "field.dispatchEvent(new Event('change', { bubbles: true }))",
        css, value, number,
    )  # fmt: skip


def looked_at(browser, server, folder, subjects=False):
    """The study of a small library that was dropped on the page, once all of it was looked at."""
    address, owner = server
    write_motions(folder, {"slow": 0.5, "fast": 2.0}, 2)
    if subjects:
        rows = [f"{pace}/{pace}_{n}.npz,{pace},{'AB'[n]}" for pace in ("slow", "fast") for n in (0, 1)]
        (folder / "labels.csv").write_text("\n".join(["file,activity,subject", *rows]))
    browser.get(address)
    wait(lambda: find(browser, "#places").get_attribute("childElementCount") != "0")
    find(browser, "#folder").send_keys(str(folder))
    wait(lambda: text(browser, "#clips").count("5.0 s at 30 frames/s") == 4)
    return Study(next(owner.iterdir()))


def test_the_first_page_shows_an_answer_before_there_is_a_study(quiet, server):
    address, _ = server
    quiet.get(address)
    wait(lambda: find(quiet, "#demo-bars").get_attribute("childElementCount") != "0")
    assert "belt clip" in text(quiet, "#demo-title")
    assert "Belt clip" in text(quiet, "#demo-bars").replace("belt clip", "Belt clip")
    pixels = "return [...document.getElementById('body').getContext('2d').getImageData(0, 0, 420, 520).data]"
    wait(lambda: any(quiet.execute_script(pixels)))
    first = quiet.execute_script(pixels)
    wait(lambda: quiet.execute_script(pixels) != first)
    assert find(quiet, "#demo").is_displayed()
    assert not find(quiet, "#mine").is_displayed()


def test_a_wish_that_is_cleared_is_taken_back(browser, server, tmp_path):
    quiet = browser
    study = looked_at(quiet, server, tmp_path / "LIB")
    typed(quiet, "#ask [name=only]", "wrist")
    typed(quiet, "#ask [name=target]", "0.95")
    typed(quiet, "#ask [name=max_places]", "2")
    typed(quiet, "#ask [name=title]", "歩行")
    typed(quiet, "#ask [name=background]", "slow")
    typed(quiet, "#ask [name=every_activity]", "0.7")
    wait(lambda: study.request()["parameters"] == {
        "only": "wrist", "target": 0.95, "max_places": 2, "title": "歩行", "by_subject": False,
        "background": "slow", "every_activity": 0.7,
    })  # fmt: skip
    assert text(quiet, "h1#headline") == "歩行"
    quiet.refresh()
    wait(lambda: find(quiet, "#ask [name=only]").get_attribute("value") == "wrist")
    for name in ("only", "target", "max_places", "background", "every_activity"):
        typed(quiet, f"#ask [name={name}]", "")
    wait(lambda: study.request()["parameters"] == {"title": "歩行", "by_subject": False})
    typed(quiet, "#ask [name=forbid]", "haed")
    wait(lambda: "did you mean head?" in text(quiet, "#problem"))


def test_a_click_on_a_part_is_a_wish_and_a_second_click_takes_it_back(quiet, server, tmp_path):
    study = looked_at(quiet, server, tmp_path / "LIB")
    click = "document.querySelector(`#ask-chips ${arguments[0]}`).click()"
    quiet.execute_script(click, "[data-word=watch]")
    quiet.execute_script(click, "[data-mode=forbid]")
    quiet.execute_script(click, "[data-word=head]")
    wait(lambda: study.request()["parameters"].get("forbid") == "head")
    assert study.request()["parameters"]["only"] == "watch"
    quiet.execute_script(click, "[data-word=head]")
    wait(lambda: "forbid" not in study.request()["parameters"])


def test_labels_are_saved_at_once_and_undone(quiet, server, tmp_path):
    study = looked_at(quiet, server, tmp_path / "LIB")
    typed(quiet, "#clips td:nth-child(3) input", "jump")
    wait(lambda: "jump" in {row.get("activity") for row in study.table()[0]})
    quiet.execute_script("document.querySelectorAll('.pick')[0].click()")
    quiet.execute_script("document.querySelectorAll('.pick')[1].click()")
    settle(quiet)
    assert text(quiet, "#many-count") == "2 clips picked"
    quiet.execute_script("document.getElementById('many-name').value = 'hop'")
    find(quiet, "#many button.main").click()
    wait(lambda: [row.get("activity") for row in study.table()[0]].count("hop") == 2)
    quiet.refresh()
    wait(
        lambda: (
            "hop"
            in quiet.execute_script(
                "return document.querySelector('#clips td:nth-child(3) input')?.value ?? ''"
            )
        )
    )
    typed(quiet, "#clips td:nth-child(3) input", "skip")
    wait(lambda: "skip" in {row.get("activity") for row in study.table()[0]})
    find(quiet, "#undo").click()
    wait(lambda: [row.get("activity") for row in study.table()[0]].count("hop") == 2)


def test_subjects_tick_for_new_people_and_a_click_takes_it_back(quiet, server, tmp_path):
    study = looked_at(quiet, server, tmp_path / "LIB", subjects=True)
    tick = "return document.querySelector('#ask [name=by_subject]').checked"
    wait(lambda: quiet.execute_script(tick))
    typed(quiet, "#ask [name=by_subject]", False)
    wait(lambda: study.request()["parameters"] == {"by_subject": False})
    quiet.refresh()
    wait(lambda: text(quiet, "#clips").count("5.0 s") == 4)
    assert not quiet.execute_script(tick)


def test_a_run_is_held_back_until_it_can_work(quiet, server, tmp_path):
    looked_at(quiet, server, tmp_path / "LIB")
    assert find(quiet, "#run").is_enabled()
    assert "fast: 2 clips, add 3" in text(quiet, "#cautions")
    quiet.execute_script("document.querySelectorAll('#clips input[type=checkbox]')[0].click()")
    settle(quiet)
    assert not find(quiet, "#run").is_enabled()
    assert "fast: 1 clip, add 1" in text(quiet, "#cautions")


def test_a_server_that_starts_again_behind_a_proxy_is_asked_again(browser, server, tmp_path, monkeypatch):
    study, done, up = looked_at(browser, server, tmp_path / "LIB"), ["0 of 24"], threading.Event()

    def progress(*_):
        return {"state": "running", "sentence": f"{done[0]}.", "answer": "", "share": 0.1}

    def events(told, **kinds):
        return StreamingResponse(told, **kinds) if up.is_set() else JSONResponse({}, 502)

    monkeypatch.setattr(Study, "progress", progress)
    monkeypatch.setattr("w2w.web.app.StreamingResponse", events)
    browser.get(f"{server[0]}/studies/{study.id}")
    wait(lambda: "does not answer" in text(browser, "#stage"))
    done[0] = "7 of 24"
    up.set()
    wait(lambda: "7 of 24" in text(browser, "#stage"))
    done[0] = "8 of 24"  # by the stream, not by asking anew
    wait(lambda: "8 of 24" in text(browser, "#stage"))


def test_one_upload_that_fails_hides_no_other(browser, server, tmp_path):
    address, _ = server
    write_motions(tmp_path / "LIB", {"slow": 0.5, "fast": 2.0}, 3)
    browser.get(address)
    wait(lambda: find(browser, "#places").get_attribute("childElementCount") != "0")
    browser.execute_script(
        "fetch = ((real, n) => (path, ...more) => path.endsWith('/files') && ++n === 2"
        " ? Promise.reject(Error('gone')) : real(path, ...more))(fetch, 0)"
    )
    find(browser, "#folder").send_keys(str(tmp_path / "LIB"))
    wait(lambda: text(browser, "#uploading") == "5 of 6 files sent, 1 failed.")
    assert "The server does not answer" in text(browser, "#refused")
    wait(lambda: browser.execute_script("return document.querySelectorAll('#clips tr').length") == 5)


def test_loose_files_are_grouped_by_their_names_if_asked(quiet, server, tmp_path):
    address, owner = server
    write_motions(tmp_path / "made", {"slow": 0.5}, 1)
    content = (tmp_path / "made/slow/slow_0.npz").read_bytes()
    heap = tmp_path / "Downloads"
    heap.mkdir()
    for name in ("walk_01", "walk_02", "Walk take 3", "jump 1", "jump-2", "X Bot@Jump (3)"):
        (heap / f"{name}.npz").write_bytes(content)
    (heap / "notes.txt").write_text("x")
    quiet.get(address)
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    find(quiet, "#folder").send_keys(str(heap))
    wait(lambda: find(quiet, "#guess").is_displayed())
    assert "notes.txt: no kind of file that holds motion" in text(quiet, "#refused")
    find(quiet, "#guess").click()
    study = Study(next(owner.iterdir()))
    wait(lambda: {row["activity"] for row in study.table()[0]} == {"walk", "jump"})


def test_folders_of_people_are_grouped_by_the_names_of_their_files_if_asked(quiet, server, tmp_path):
    address, owner = server
    write_motions(tmp_path / "made", {"slow": 0.5}, 1)
    content = (tmp_path / "made/slow/slow_0.npz").read_bytes()
    for person in ("Anna B", "ben"):
        (tmp_path / "CLIPS" / person).mkdir(parents=True)
        for name in ("squat well 1", "squat badly 1"):
            (tmp_path / "CLIPS" / person / f"{name}.npz").write_bytes(content)
    quiet.get(address)
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    find(quiet, "#folder").send_keys(str(tmp_path / "CLIPS"))
    wait(lambda: find(quiet, "#guess").is_displayed())
    assert "squat_badly, squat_well" in text(quiet, "#guess-text")
    find(quiet, "#guess").click()
    study = Study(next(owner.iterdir()))
    whole = {
        ("squat_well", "Anna B"),
        ("squat_badly", "Anna B"),
        ("squat_well", "ben"),
        ("squat_badly", "ben"),
    }
    wait(lambda: {(row["activity"], row["subject"]) for row in study.table()[0]} == whole)
    assert find(quiet, "#ask [name=by_subject]").is_selected()


def test_an_answer_of_before_is_marked_and_shared_by_a_link(quiet, server, drawn_results):
    address, owner = server
    study = finished(owner, drawn_results)
    quiet.get(f"{address}/studies/{study.id}")
    wait(lambda: find(quiet, "#report").get_attribute("src"))
    assert not find(quiet, "#stale").is_displayed()
    assert "Kept until" in text(quiet, "#kept")
    quiet.execute_script("document.getElementById('share').closest('details').open = true")
    quiet.execute_script("document.getElementById('steps').open = true")
    find(quiet, "#share").click()
    link = wait(lambda: find(quiet, "#link").get_attribute("value"))
    typed(quiet, "#clips td:nth-child(3) input", "jump")
    wait(lambda: "their labels changed" in text(quiet, "#stale"))
    assert find(quiet, "#report").value_of_css_property("opacity") == "0.55"
    quiet.get(link)
    wait(lambda: quiet.find_elements("css selector", ".stage.live"))
    assert text(quiet, "h1") == study.answer()


SAID = {"next": "Two more people.", "cautions": [], "skipped": [["Cy.csv", "no activity"]]}


@pytest.fixture
def pilot(quiet, server, drawn_results, monkeypatch):
    """The page of an answer with its pilot open, and what was sent to be held against the map."""
    address, owner = server
    study, held = finished(owner, drawn_results), []

    async def work(_, study, __, how, asked):
        """What the worker does, but for a pilot: the results drawn here have no signals."""
        if how is not pilot_by:
            return how(study.results, asked)
        folder, at = asked
        sent = sorted(file.relative_to(folder).as_posix() for file in folder.rglob("*.csv"))
        held.append(Recordings.read(folder, place=at, activities=["walking"]))
        return {"sentence": f"{at}: {', '.join(sent)}."} | SAID

    monkeypatch.setattr(Answers, "_worked", work)
    quiet.get(f"{address}/studies/{study.id}")
    wait(lambda: find(quiet, "#report").get_attribute("src"))
    quiet.execute_script("document.getElementById('pilot').closest('details').open = true")
    yield held
    assert not text(quiet, "#problem")


def test_a_pilot_is_sent_and_what_it_says_is_shown(quiet, pilot, tmp_path):
    find(quiet, "#pilot button").click()
    wait(lambda: "Choose a folder or files" in text(quiet, "#problem"))
    files = [toolbox(tmp_path / f"{who} walking.csv", 30) for who in ("Ada", "Ben")]
    find(quiet, "#worn-files").send_keys("\n".join(map(str, [*files, drawing_of(tmp_path)])))
    wait(lambda: len(quiet.find_elements("css selector", "#worn canvas")) == 2)
    assert "Left out: drawing.csv: drawing.csv: no line names a time" in text(quiet, "#pilot-said")
    typed(quiet, "#worn-at", "belt clip")
    find(quiet, "#pilot .main").click()
    said = "belt clip: Ada walking.csv, Ben walking.csv, drawing.csv. Two more people. "
    said += "Left out: Cy.csv: no activity."
    wait(lambda: text(quiet, "#pilot-said") == said)
    assert [(one.subject, round(one.time[-1])) for one in pilot[0]] == [("ada", 24), ("ben", 24)]


def test_stretches_are_marked_by_mouse_and_by_keys(quiet, pilot, tmp_path):
    from selenium.webdriver import ActionChains, Keys

    worn = tmp_path / "worn"
    for who in ("Ada", "Ben"):
        toolbox(worn / who / "session.csv", 60, mark=";", comma=True)
    find(quiet, "#worn-folder").send_keys(str(worn))
    wait(lambda: len(quiet.find_elements("css selector", "#worn canvas")) == 2)
    canvases = quiet.find_elements("css selector", "#worn canvas")
    quiet.execute_script("arguments[0].scrollIntoView({ block: 'center' })", canvases[0])
    wide = canvases[0].size["width"]
    for start, end in ((-0.4, -0.1), (0.4, 0.1)):  # forwards, and backwards
        drag = ActionChains(quiet).move_to_element_with_offset(canvases[0], round(start * wide), 10)
        drag.click_and_hold().move_by_offset(round((end - start) * wide), 5).release().perform()
        ActionChains(quiet).send_keys("walking" if start < 0 else 'sitting, "still"').perform()
    inked = (
        "const top = arguments[0].getContext('2d').getImageData(0, 0, arguments[0].width, 1).data;"
        "return [...top].filter((value, at) => at % 4 === 3 && value).length"
    )
    assert quiet.execute_script(inked, canvases[0]) > 0.5 * wide
    assert not violations(quiet)

    quiet.execute_script(
        "document.querySelectorAll('#worn > li')[1].querySelector(':scope > button').focus()"
    )
    for keys in (Keys.ENTER, "sitting"):  # a stretch, whose activity has the focus
        ActionChains(quiet).send_keys(keys).perform()
    ActionChains(quiet).key_down(Keys.SHIFT).send_keys(Keys.TAB, Keys.TAB).key_up(Keys.SHIFT).perform()
    for keys in ("12.5", Keys.TAB, "40"):
        ActionChains(quiet).send_keys(keys).perform()
    quiet.execute_script(
        "document.querySelectorAll('#worn > li')[1].querySelector(':scope > button').click()"
    )
    find(quiet, "#pilot .main").click()  # its activity is missing: nothing is sent
    settle(quiet)
    assert not pilot
    quiet.find_elements("css selector", "#worn li li .button")[-1].click()
    find(quiet, "#pilot .main").click()
    wait(lambda: pilot)
    rows = [(one.subject, one.activity, one.clip, one.time[-1]) for one in pilot[0]]
    assert [row[:2] for row in rows] == [("Ada", "walking"), ("Ada", 'sitting, "still"'), ("Ben", "sitting")]
    assert rows[2][2:] == ("Ben/session from 12.5 s", pytest.approx(27.5, abs=0.1))
    starts = [float(row[2].split()[-2]) for row in rows]
    assert starts[:2] == [pytest.approx(6, abs=0.5), pytest.approx(36, abs=0.5)]
    assert [row[3] for row in rows[:2]] == [pytest.approx(18, abs=0.5)] * 2


def toolbox(path, seconds, **how):
    """An export of Physics Toolbox of so many seconds."""
    t, gravity, moved, gyr = motion(seconds)
    names = ["time", "gFx", "gFy", "gFz", "wx", "wy", "wz"]
    return table(path, names, t, (gravity + moved) / G, gyr, **how)


def drawing_of(folder):
    """A csv that is no recording."""
    path = folder / "drawing.csv"
    path.write_text("shape,colour\ncircle,red\n")
    return path


def test_one_answer_changes_as_a_whole_with_the_wishes(quiet, server, drawn_results, monkeypatch):
    address, owner = server
    study = finished(owner, drawn_results)
    asked = []

    async def choose(_, study, wishes, how, __=None):
        """What the worker would find; the results drawn here have no signals to choose by."""
        asked.append((how.__name__, wishes))
        if how is report_needing:
            raise RefusedError(400, "There are no signals to try with.")
        sentence = f"Without {wishes['forbid']}." if wishes.get("forbid") else study.answer()
        if how is report_again:
            page = (study.results / "report.html").read_text(encoding="utf-8")
            return re.sub("<h1>.*?</h1>", f"<h1>{escape(sentence)}</h1>", page, flags=re.DOTALL)
        return {"answer": {"sentence": sentence}, "worn_together": None}

    monkeypatch.setattr(Answers, "_choose", choose)
    study.change(parameters={"max_places": 2})
    quiet.get(f"{address}/studies/{study.id}")
    wait(lambda: find(quiet, "#report").get_attribute("src"))
    headline = (
        "const inner = document.getElementById('report').contentDocument;"
        "return inner && inner.querySelector('h1') ? inner.querySelector('h1').textContent : ''"
    )
    first = wait(lambda: quiet.execute_script(headline))
    typed(quiet, "#again [name=forbid]", "watch")
    wait(lambda: quiet.execute_script(headline) == "Without watch.")
    assert "Without watch." in text(quiet, "#chosen")
    quiet.execute_script("document.getElementById('keep-choice').click()")
    assert "never at watch" in text(quiet, "#choices")
    typed(quiet, "#again [name=forbid]", "")
    typed(quiet, "#again [name=max_places]", "")
    wait(lambda: ("report_again", {"max_places": ""}) in asked)
    wait(lambda: quiet.execute_script(headline) == first)
    quiet.execute_script("document.querySelector('#choices button').click()")
    wait(lambda: quiet.execute_script(headline) == "Without watch.")

    cheap = "document.getElementById('report').contentDocument.getElementById('how-cheap').click()"
    quiet.execute_script(cheap)
    wait(lambda: text(quiet, "#problem") == "There are no signals to try with.")
    assert ("report_needing", {"forbid": "watch", "max_places": 2}) in asked
    wait(lambda: quiet.execute_script(headline) == "Without watch.")
    quiet.get_log("browser")  # the refusal


def violations(browser):
    """What axe finds on the page, outside the report."""
    browser.execute_script(Path(axe_core_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8"))
    return browser.execute_async_script(
        "axe.run({ exclude: ['iframe'] })"
        ".then((r) => arguments[0](r.violations.map((v) => [v.id, v.nodes[0].html])))"
    )


@pytest.mark.parametrize(
    ("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 400), ("dark", 400)]
)
def test_axe_finds_nothing(quiet, server, drawn_results, scheme, width):
    address, owner = server
    study = finished(owner, drawn_results)
    media = [{"name": "prefers-color-scheme", "value": scheme}]
    quiet.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
    quiet.set_window_size(width, 1000)
    paths = {"/": "#studies li", f"/studies/{study.id}": "#clips tr", "/operator": "tbody tr"}
    for path, part in paths.items():
        quiet.get(address + path)
        wait(lambda part=part: quiet.find_elements("css selector", part))
        quiet.execute_script("fetch = () => new Promise(() => 0)")
        quiet.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
        settle(quiet)
        assert not violations(quiet)
        assert quiet.execute_script("return document.documentElement.scrollWidth <= innerWidth")


def test_paper_has_the_answer_alone(quiet, server, drawn_results):
    address, owner = server
    study = finished(owner, drawn_results)
    quiet.get(f"{address}/studies/{study.id}")
    wait(lambda: find(quiet, "#report").get_attribute("src"))
    drawn = "return document.getElementById('report').contentDocument.querySelector('h1') !== null"
    wait(lambda: quiet.execute_script(drawn))
    made = quiet.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})["data"]
    first = pdfium.PdfDocument(base64.b64decode(made))[0].get_textpage().get_text_bounded()
    assert " ".join(study.answer().split()) in " ".join(first.split())
    assert "Expected F1" in first
    assert "What if" not in first
