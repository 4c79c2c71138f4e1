# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing again in the web app: a wish goes before the run's own, "" takes that back, nothing keeps it."""

from types import SimpleNamespace

import pytest

from w2w.core.selection.constraints import Constraints
from w2w.core.study.config import StudyConfig
from w2w.web import choosing


@pytest.fixture
def chosen_by(tmp_path, monkeypatch):
    """Chooses again over a run of its own wishes, and gives the parameters that it chose by."""
    run = StudyConfig(target=0.9, every_activity=0.2, max_places=4, constraints=Constraints(forbid=("head",)))
    clips = (SimpleNamespace(activity="walk"),)
    study = SimpleNamespace(
        config=lambda: run, clips=clips, utility=None, patches=None, summary={"cautions": []}
    )
    choices = SimpleNamespace(study=study, under=lambda config: config)
    choices.weighed = lambda _config: choices
    monkeypatch.setattr(choosing, "_opened", lambda *_: choices)
    monkeypatch.setattr(choosing, "advice_content", lambda config, *_: {"config": config})
    (tmp_path / "summary.json").write_text("{}")
    return lambda **wishes: choosing.choose_again(tmp_path, {"compare": "", **wishes})["config"]


def test_wishes_go_before_the_runs_own(chosen_by):
    config = chosen_by(target=0.7, every_activity=0.6, max_places=2, only="left", forbid="")
    assert (config.target, config.every_activity, config.max_places) == (0.7, 0.6, 2)
    assert (config.constraints.only, config.constraints.forbid) == (("left",), ())


def test_zero_is_a_wish(chosen_by):
    assert chosen_by(every_activity=0).every_activity == 0
    assert chosen_by().every_activity == 0.2


def test_without_wishes_it_is_chosen_as_the_run_did(chosen_by):
    config = chosen_by()
    assert (config.target, config.max_places, config.constraints.forbid) == (0.9, 4, ("head",))
