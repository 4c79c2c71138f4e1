# SPDX-License-Identifier: GPL-3.0-or-later
"""The app's page in headless Chromium: clips go up, labels are edited, the answer's report is alive."""

import shutil
import threading
import time
from pathlib import Path

import axe_core_python
import pytest
import uvicorn

from w2w.core.files import write_json, write_text
from w2w.headless.commands.report import write_report
from w2w.web.app import web_app
from w2w.web.guard import Doors
from w2w.web.study import EVENTS, INPUT, Study
from w2w.web.work import Work

from ..headless.conftest import few_orders, made_once_here, one_worker, write_motions
from ..patience import HANG_S
from ..report.browser import find, settle, text
from ..report.conftest import browser, drawn, drawn_results

__all__ = ["browser", "drawn", "drawn_results", "few_orders", "made_once_here", "one_worker"]


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
def quiet(browser):
    """The browser; at the end, nothing was refused by the page's policy and nothing failed."""
    browser.get_log("browser")
    yield browser
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


def test_folders_are_dropped_on_the_page(quiet, server, tmp_path):
    """A drag from a file manager, as the browser itself sees it."""
    address, owner = server
    write_motions(tmp_path, {"slow": 0.5, "fast": 2.0}, 1)
    quiet.get(address)
    wait(lambda: find(quiet, "#places").get_attribute("childElementCount") != "0")
    zone = find(quiet, "#zone").rect
    dragged = {
        "x": zone["x"] + zone["width"] / 2,
        "y": zone["y"] + zone["height"] / 2,
        "data": {
            "items": [],
            "files": [str(tmp_path / "slow"), str(tmp_path / "fast")],
            "dragOperationsMask": 1,
        },
    }
    for kind in ("dragEnter", "dragOver"):
        quiet.execute_cdp_cmd("Input.dispatchDragEvent", {"type": kind, **dragged})
    assert "over" in find(quiet, "#zone").get_attribute("class")
    quiet.execute_cdp_cmd("Input.dispatchDragEvent", {"type": "drop", **dragged})
    wait(lambda: text(quiet, "#uploading") == "2 of 2 files sent.")
    assert "over" not in find(quiet, "#zone").get_attribute("class")
    wait(lambda: text(quiet, "#clips").count("5.0 s at 30 frames/s") == 2)
    (study,) = (Study(folder) for folder in owner.iterdir())
    assert {row["activity"] for row in study.table()[0]} == {"slow", "fast"}


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


@pytest.mark.parametrize(
    ("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 400), ("dark", 400)]
)
def test_axe_finds_nothing(quiet, server, drawn_results, scheme, width):
    address, owner = server
    study = finished(owner, drawn_results)
    script = Path(axe_core_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    media = [{"name": "prefers-color-scheme", "value": scheme}]
    quiet.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
    quiet.set_window_size(width, 1000)
    for path, part in (("/", "#studies li"), (f"/studies/{study.id}", "#clips tr")):
        quiet.get(address + path)
        wait(lambda part=part: quiet.find_elements("css selector", part))
        quiet.execute_script("fetch = () => new Promise(() => 0)")
        quiet.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
        settle(quiet)
        quiet.execute_script(script)
        found = quiet.execute_async_script(
            "axe.run({ exclude: ['iframe'] })"
            ".then((r) => arguments[0](r.violations.map((v) => [v.id, v.nodes[0].html])))"
        )
        assert not found
        assert quiet.execute_script("return document.documentElement.scrollWidth <= innerWidth")
