# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's choice of sensors is that of `w2w place`, wish for wish and number for number."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.core.study import choosing
from w2w.core.study.results import StudyResults
from w2w.headless.app import APP
from w2w.scene.base.patches import empties_by_patch
from w2w.ui.jobs import jobs
from w2w.ui.steps import baking
from w2w.ui.steps.choosing import choose_steps
from w2w.ui.study import signal_cache
from w2w.ui.study.lists import advice_of, answer_of, comparison_of, leading
from w2w.ui.study.state import FORBID, config_of, constraints_of, patches_of, utility_of

from .made_study import make_study
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

WISHES = 24

WORDS = (
    "left", "right", "middle", "head", "torso", "arm", "hand", "leg", "foot", "left arm", "right leg",
    "chest", "left wrist", "thigh front", "waist", "sternum", "upper arm", "belt", "tail",
)  # fmt: skip


def set_wishes(study: bpy.types.PropertyGroup, wishes: list[tuple[str, str, float]]) -> None:
    """Fill the panel's list as a person does."""
    study.wishes.clear()
    for kind, place, cost in wishes:
        assert bpy.ops.w2w.add_wish(kind=kind) == {"FINISHED"}
        study.wishes[-1].place = place
        if kind == "COST":
            study.wishes[-1].cost = cost


def options(wishes: list[tuple[str, str, float]], folder: Path) -> list[str]:
    """The same wishes for the command line."""
    given = []
    for kind in ("ONLY", "FORBID", "MUST"):
        places = [place for name, place, _ in wishes if name == kind]
        given += [f"--{kind.lower()}", ",".join(places)]  # an empty word takes the run's back
    costs = [f"{place},{cost}\n" for kind, place, cost in wishes if kind == "COST"]
    if costs:
        (folder / "costs.csv").write_text("region,cost\n" + "".join(costs))
        given += ["--cost", str(folder / "costs.csv")]
    return given


def place(results: Path, folder: Path, *more: str) -> tuple[dict | None, str]:
    """What `w2w place` writes, and what it says."""
    file = folder / "choice.json"
    file.unlink(missing_ok=True)
    done = CliRunner().invoke(APP, ["place", str(results), "--out", str(file), *more])
    assert done.exit_code in (0, 2), done.output
    return (json.loads(file.read_text()) if file.exists() else None), " ".join(done.output.split())


@pytest.mark.slow
def test_drawn_wishes_get_the_same_answer_at_both_doors(finished_run: Path, tmp_path: Path) -> None:
    study = open_file(finished_run / "study.blend").w2w
    rng = np.random.default_rng(11)
    answered = 0
    for _ in range(WISHES):
        kinds = rng.choice(["ONLY", "FORBID", "MUST", "COST"], rng.integers(0, 4), p=[0.2, 0.3, 0.2, 0.3])
        wishes = [(kind, str(rng.choice(WORDS)), round(float(rng.uniform(0.1, 4)), 3)) for kind in kinds]
        target, limit = round(float(rng.uniform(0.5, 1)), 3), int(rng.integers(1, 7))
        set_wishes(study, wishes)
        study.target, study.max_places = target, limit
        more = ["--target", str(target), "--max", str(limit), *options(wishes, tmp_path)]
        choice, said = place(finished_run, tmp_path, *more)
        if choice is None:
            with pytest.raises(RuntimeError) as refused:
                bpy.ops.w2w.choose_sensors()
            assert " ".join(str(refused.value).removeprefix("Error: ").split()) in said, wishes
            continue
        answered += 1
        assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
        assert advice_of(study) == choice, wishes
        assert [row.patch for row in study.chosen] == [choice["answer"]["patch"]]
        assert [row.patch for row in study.worn] == [
            row["patch"] for row in choice["worn_together"]["places"]
        ]
    assert answered > WISHES / 2


def test_a_further_choice_goes_on_from_what_the_first_found_out(
    finished_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study, made, make = open_file(finished_run / "study.blend").w2w, [], choosing.stream_in
    monkeypatch.setattr(choosing, "stream_in", lambda *given: made.append(given) or make(*given))
    baking.known.clear()
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    set_wishes(study, [("MUST", "tail", 1.0)])
    with pytest.raises(RuntimeError, match="no patch is called 'tail'"):
        bpy.ops.w2w.choose_sensors()
    set_wishes(study, [("FORBID", "left arm", 1.0)])
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert len(made) == 1
    found = advice_of(study)
    baking.known.clear()
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert len(made) == 2
    assert advice_of(study) == found


@pytest.mark.slow
def test_a_study_of_the_panel_is_answered_as_its_saved_folder(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    set_wishes(body.w2w, [("FORBID", "right arm", 1.0), ("MUST", "left leg, head", 1.0)])
    body.w2w.target = 1.0
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    wishes = ["--forbid", "right arm", "--must", "left leg,head", "--target", "1"]
    choice, _ = place(tmp_path / "saved", tmp_path, *wishes)
    assert advice_of(body.w2w) == choice
    assert StudyResults.load(tmp_path / "saved").config().constraints == constraints_of(body.w2w)


def spheres(body: bpy.types.Object) -> set[int]:
    """Patches that are marked as chosen."""
    found = empties_by_patch(body.w2w.chosen_collection)
    assert {item.empty_display_type for item in found.values()} <= {"SPHERE"}
    return set(found)


def test_a_run_opens_with_its_wishes_and_the_set_it_says_to_wear(finished_run: Path, summary: dict) -> None:
    body = open_file(finished_run / "study.blend")
    study = body.w2w
    assert [(wish.kind, wish.place) for wish in study.wishes] == [(FORBID, "foot")]
    worn = summary["worn_together"]
    assert advice_of(study)["worn_together"] == worn
    assert [row.patch for row in study.worn] == [row["patch"] for row in worn["places"]]
    assert study.worn[-1].f1 == pytest.approx(worn["expected_f1"])
    assert (study.worn[-1].low, study.worn[-1].high) == pytest.approx(worn["expected_f1_interval"])
    assert spheres(body) == {row.patch for row in study.worn}
    study.wishes[0].place = "leg"
    assert advice_of(study) is None
    assert leading(study) == study.chosen
    assert spheres(body) == {row.patch for row in study.chosen}
    study.wishes[0].place = "foot"
    assert advice_of(study) is not None
    assert spheres(body) == {row.patch for row in study.worn}


@pytest.mark.slow
def test_costs_keep_the_digits_that_the_command_line_read(finished_run: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(finished_run, folder)
    config = json.loads((folder / "config.json").read_text())
    config["parameters"]["constraints"]["costs"] = [["leg", 1 / 3]]
    (folder / "config.json").write_text(json.dumps(config))
    assert bpy.ops.w2w.open_results(filepath=str(folder)) == {"FINISHED"}
    study = bpy.context.scene.w2w.body.w2w
    assert constraints_of(study).costs == (("leg", 1 / 3),)
    study.wishes[-1].cost = 0.7
    assert constraints_of(study).costs == (("leg", 0.7),)


def test_wishes_come_from_the_regions_looked_at(finished_run: Path) -> None:
    body = open_file(finished_run / "study.blend")
    assert not bpy.ops.w2w.wish_picked.poll()
    regions = patches_of(body).regions
    bpy.ops.w2w.select_patch(patch=7)
    assert bpy.ops.w2w.wish_picked(kind="MUST") == {"FINISHED"}
    bpy.ops.w2w.select_patch(patch=20, compare=True)
    assert bpy.ops.w2w.wish_picked(kind="MUST") == {"FINISHED"}
    assert constraints_of(body.w2w).must == (regions[7], regions[20])
    assert bpy.ops.w2w.remove_wish(index=1) == {"FINISHED"}
    assert constraints_of(body.w2w).must == (regions[20],)


@pytest.mark.slow
def test_a_wish_that_nothing_meets_says_so_and_one_without_a_place_is_none(finished_run: Path) -> None:
    study = open_file(finished_run / "study.blend").w2w
    before = [row.patch for row in study.chosen]
    bpy.ops.w2w.add_wish(kind="ONLY")
    assert [row.patch for row in study.chosen] == before
    study.wishes[-1].place = "tail"
    assert answer_of(study)["sentence"].startswith("No patch is called 'tail'")
    assert not study.chosen
    with pytest.raises(RuntimeError, match="no patch is called 'tail'"):
        bpy.ops.w2w.choose_sensors()


def test_a_limit_can_be_switched_on_and_off(finished_run: Path) -> None:
    study = open_file(finished_run / "study.blend").w2w
    assert (study.limit_places, study.max_places) == (True, 3)
    study.limit_places = False
    assert config_of(study).max_places is None
    study.limit_places = True
    assert config_of(study).max_places == 3


@pytest.mark.slow
def test_without_an_activity_the_choice_is_that_of_the_folder_saved_without_it(
    finished_run: Path, tmp_path: Path
) -> None:
    body = open_file(finished_run / "study.blend")
    body.w2w.activities["run"].part = "LEFT_OUT"
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert jobs.message.text.endswith(". Without run")
    content = advice_of(body.w2w)
    assert set(content["worn_together"]["f1"]) == {"bow", "walk_left"}
    assert leading(body.w2w) == body.w2w.worn
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    choice, _ = place(tmp_path / "saved", tmp_path, "--forbid", "foot", "--max", "3", "--target", "0.85")
    assert content == choice
    body.w2w.activities["run"].part = "COUNTED"
    assert advice_of(body.w2w) is None


def test_one_activity_alone_cannot_be_chosen_for(finished_run: Path) -> None:
    body = open_file(finished_run / "study.blend")
    for name in ("run", "bow"):
        body.w2w.activities[name].part = "LEFT_OUT"
    with pytest.raises(RuntimeError, match="activit"):
        bpy.ops.w2w.choose_sensors()


def test_what_the_choice_waits_for_is_said(finished_run: Path) -> None:
    body = open_file(finished_run / "study.blend")
    assert bpy.ops.w2w.choose_sensors.poll()
    body.w2w.clips[0].activity = "greeting"
    assert not bpy.ops.w2w.choose_sensors.poll()


def test_esc_leaves_the_choice_as_it_was(finished_run: Path) -> None:
    body = open_file(finished_run / "study.blend")
    body.w2w.target = 0.99
    before = body.w2w.advice_text
    steps = choose_steps(body)
    next(steps)
    steps.close()
    assert body.w2w.advice_text == before


def test_signals_that_are_gone_are_said(finished_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    open_file(finished_run / "study.blend")
    monkeypatch.setattr(signal_cache, "has", lambda _key: False)
    with pytest.raises(RuntimeError, match="The signals of 9 clips are gone"):
        bpy.ops.w2w.choose_sensors()


@pytest.mark.slow
def test_places_are_compared_as_on_the_command_line(finished_run: Path, tmp_path: Path) -> None:
    assert bpy.ops.w2w.open_results(filepath=str(finished_run)) == {"FINISHED"}
    study = bpy.context.scene.w2w.body.w2w
    names = patches_of(study.id_data).names
    study.compare = f"{names[3]}, {names[17]}"
    found, unknown = comparison_of(study)
    assert found == place(finished_run, tmp_path, "--compare", study.compare)[0]
    assert {row["patch"] for row in found} == {3, 17}
    assert unknown == ""
    study.compare = f"tail, {names[3]}"
    assert place(finished_run, tmp_path, "--compare", "tail")[0] is None
    found, unknown = comparison_of(study)
    assert [row["patch"] for row in found] == [3]
    assert "tail" in unknown
    study.compare = ""
    assert comparison_of(study) == ([], "")


def test_choosing_sensors_leaves_map_and_answer_as_the_ranking_said_them(finished_run: Path) -> None:
    study = open_file(finished_run / "study.blend").w2w
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    ranked, answered, coloured = utility_of(study), answer_of(study), study.utility_key
    assert ranked is not None
    assert ranked.lost is not None
    study.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert answer_of(study) == answered
    assert study.utility_key == coloured


def test_a_wish_takes_the_answer_before_away_from_the_message(library: Path) -> None:
    body = make_study(library)
    for is_error in (False, True):
        jobs.message = jobs.Message("Done: Wear an earbud", is_error)
        bpy.ops.w2w.add_wish(kind="FORBID", place="head")
        assert (jobs.message is not None) is is_error
    jobs.dismiss()
    assert len(body.w2w.wishes) == 2
