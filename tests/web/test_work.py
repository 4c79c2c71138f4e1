# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs, their queue and what is kept: nothing that befalls one study stops the others."""

import asyncio
import json
import shutil
import time
from errno import ENOSPC

import pytest

from w2w.web import work as work_module
from w2w.web.request import EVENTS, IDLE, REQUEST
from w2w.web.study import Study
from w2w.web.uploads import RefusedError
from w2w.web.work import KILLED, Queue, Work

from ..patience import HANG_S

ENDED = 'import time; print(\'{"event": "finished", "exit_code": 0}\', flush=True); time.sleep(.4)'


@pytest.fixture
def data(tmp_path):
    return tmp_path


@pytest.fixture
def quick(monkeypatch):
    """Runs that say that they have finished, and end a moment later."""
    monkeypatch.setattr(work_module, "COMMAND", ENDED)


def asked(owner, at=1.0):
    study = Study.make(owner)
    study.change(asked=at)
    return study


async def until(true):
    end = time.monotonic() + HANG_S
    while not true():
        assert time.monotonic() < end
        await asyncio.sleep(0.01)


@pytest.mark.usefixtures("quick")
def test_a_run_asked_for_right_after_the_last_has_ended_is_done(data):
    study = Study.make(data / "local")

    async def twice():
        work = Work(data, 1, "", 30.0)
        for at in (1.0, 2.0):
            study.ask({"asked": at})
            work.run(study)
            await until(lambda: study.end() is not None)
        await until(lambda: not work._runs)
        await work.stop()

    asyncio.run(twice())
    assert study.end() == {"event": "finished", "exit_code": 0}
    assert KILLED not in (study.folder / EVENTS).read_text()


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    "error", [OSError(ENOSPC, "No space left on device"), RefusedError(500, "it is damaged")]
)
def test_what_goes_wrong_at_a_start_is_said_and_the_queue_goes_on(data, monkeypatch, error):
    bad, good = asked(data / "local", 1.0), asked(data / "local", 2.0)
    command = Study.command

    def fails(study, *more):
        if study == bad:
            raise error
        return command(study, *more)

    monkeypatch.setattr(Study, "command", fails)

    async def both():
        work = Work(data, 1, "", 30.0)
        work.start()
        await until(lambda: good.end() is not None and bad.end() is not None)
        await work.stop()

    asyncio.run(both())
    assert bad.end()["problem"].startswith("The run could not be started: ")
    assert ("disk is full" in bad.end()["problem"]) == isinstance(error, OSError)
    assert good.end()["exit_code"] == 0


@pytest.mark.parametrize(
    "content", ["", "{", "[]", "3", '{"files": 3}', '{"asked": "soon"}', "\0" * 99, '{"a":' * 9999]
)
def test_one_damaged_request_never_stops_the_server(opened, tmp_path, content):
    bad, good = asked(tmp_path / "data/local"), Study.make(tmp_path / "data/local")
    (bad.folder / REQUEST).write_text(content)
    client = opened()
    listed = {study["id"]: study for study in client.get("/api/studies").json()}
    assert listed[good.id]["state"] == "draft"
    assert "damaged" in listed[bad.id]["sentence"]
    assert "damaged" in client.get(f"/api/studies/{bad.id}").json()["problem"]
    assert client.delete(f"/api/studies/{bad.id}").status_code == 200
    assert not bad.folder.exists()


@pytest.mark.parametrize("moment", ["request", "progress"])
def test_a_study_deleted_while_all_are_listed_is_left_out(opened, tmp_path, monkeypatch, moment):
    gone, stays = Study.make(tmp_path / "data/local"), Study.make(tmp_path / "data/local")
    client, told = opened(), getattr(Study, moment)

    def told_too_late(study, *more):
        if study == gone:
            shutil.rmtree(gone.folder, ignore_errors=True)
        return told(study, *more)

    monkeypatch.setattr(Study, moment, told_too_late)
    assert [study["id"] for study in client.get("/api/studies").json()] == [stays.id]


def test_places_in_the_queue_go_round_among_people(data):
    first = [asked(data / "anna") for _ in range(3)]
    second = asked(data / "bert")

    async def order():
        queue, served = Queue(1), []

        async def turn(study):
            await queue.wait(study)
            served.append(study)
            await asyncio.sleep(0)
            queue.leave()

        tasks = [asyncio.create_task(turn(study)) for study in (*first, second)]
        await asyncio.sleep(0)
        assert queue.before(second) == 0
        assert queue.before(first[2]) == 2
        await asyncio.gather(*tasks)
        return served

    assert asyncio.run(order()) == [first[0], second, *first[1:]]


def test_who_leaves_the_queue_keeps_no_place(data):
    async def leave():
        queue = Queue(1)
        await queue.wait(asked(data / "anna"))
        task = asyncio.create_task(queue.wait(asked(data / "anna")))
        await asyncio.sleep(0)
        queue.leave()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await asyncio.wait_for(queue.wait(asked(data / "bert")), HANG_S)

    asyncio.run(leave())


def look(data, keep_days):
    async def once():
        work = Work(data, 1, "", keep_days)
        work.start()
        await asyncio.sleep(0.05)
        await work.stop()

    asyncio.run(once())


@pytest.mark.parametrize("days", [-7, 7, 400])
def test_a_clock_that_jumps_deletes_nothing(data, monkeypatch, days):
    study = Study.make(data / "local")
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() + 86400 * days)
    look(data, 1.0)
    assert study.folder.exists()


def test_a_study_is_kept_from_the_last_visit_on_and_longer_if_asked(opened, tmp_path):
    client = opened()
    study = Study.make(tmp_path / "data/local")
    study.set_idle(86400 * 20)
    assert client.get(f"/api/studies/{study.id}").json()["days_left"] == 30
    assert client.post(f"/api/studies/{study.id}/keep", json={}).json()["days_left"] == 60
    assert client.get(f"/api/studies/{study.id}").json()["days_left"] == 60
    study.set_idle(86400 * 31)
    look(tmp_path / "data", 30.0)
    assert not study.folder.exists()


def test_time_without_visitors_adds_up_over_servers(data):
    study = Study.make(data / "local")
    study.set_idle(100.0)
    look(data, 30.0)
    assert 100.0 < float((study.folder / IDLE).read_text()) < 100.0 + HANG_S


def test_a_state_of_an_earlier_run_is_not_shown_whatever_the_clock_says(data):
    study = asked(data / "local", at=time.time() + 86400 * 7)
    (study.results / ".w2w").mkdir(parents=True)
    state = {"step": "reading clips", "clips": 4, "done": 2, "started": time.time()}
    (study.results / ".w2w/state.json").write_text(json.dumps(state))
    assert study.progress(running=True)["share"] == 0
    (study.folder / EVENTS).write_text('{"time": "x", "event": "started"}\n')
    assert study.progress(running=True)["share"] == 0.5
