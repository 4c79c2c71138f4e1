# SPDX-License-Identifier: GPL-3.0-or-later
"""What is exported from the panel is, byte for byte, what Python and the command line write."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from typer.testing import CliRunner

from w2w.core.imu.formats import write_recording
from w2w.core.imu.recording import ImuRecording
from w2w.core.study.clip_files import signals_file
from w2w.core.study.results import StudyResults
from w2w.headless.app import APP
from w2w.ui.files.exports import report_steps
from w2w.ui.jobs import jobs
from w2w.ui.study import signal_cache
from w2w.ui.study.state import patches_of

from .made_study import make_study
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


@pytest.fixture
def opened(finished_run: Path) -> bpy.types.Object:
    """The body of the run's study.blend, opened in place."""
    return open_file(finished_run / "study.blend")


@pytest.mark.usefixtures("blender", "opened")
def test_the_table_is_the_runs(finished_run: Path, tmp_path: Path) -> None:
    assert bpy.ops.w2w.export_table(filepath=str(tmp_path / "utility")) == {"FINISHED"}
    assert (tmp_path / "utility.csv").read_bytes() == (finished_run / "utility.csv").read_bytes()
    assert jobs.message.text == f"Saved the table: {tmp_path / 'utility.csv'}"


@pytest.mark.usefixtures("blender", "opened")
def test_signals_of_all_patches_are_the_runs(finished_run: Path, tmp_path: Path) -> None:
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "all"), which="ALL") == {"FINISHED"}
    names = [clip.name for clip in StudyResults.load(finished_run).clips]
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == sorted(f"{n}.npz" for n in names)
    for name in names:
        saved = (tmp_path / "all" / f"{name}.npz").read_bytes()
        assert saved == signals_file(finished_run, name).read_bytes()


@pytest.mark.parametrize(("kind", "suffix"), [("csv", ".csv"), ("xsens", ".txt"), ("npz", ".npz")])
def test_signals_of_a_patch_are_those_of_its_sensor(
    opened: bpy.types.Object, finished_run: Path, tmp_path: Path, kind: str, suffix: str
) -> None:
    bpy.ops.w2w.select_patch(patch=20)
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "one"), kind=kind) == {"FINISHED"}
    place = patches_of(opened).names[20].replace(" ", "_")
    files = sorted((tmp_path / "one").iterdir())
    assert len(files) == 9
    for clip in StudyResults.load(finished_run).clips:
        stored = ImuRecording.load(signals_file(finished_run, clip.name))
        one = ImuRecording(
            stored.acc[:, 20:21],
            stored.gyr[:, 20:21],
            stored.rate,
            stored.sites[20:21],
            stored.activity,
            stored.subject,
            stored.clip,
        )
        write_recording(tmp_path / "core", one, kind)
        saved = tmp_path / "one" / f"{clip.name}_{place}{suffix}"
        assert saved.read_bytes() == (tmp_path / "core").read_bytes()
    with pytest.raises(RuntimeError, match="already holds"):
        bpy.ops.w2w.export_signals(directory=str(tmp_path / "one"), kind=kind)


@pytest.mark.usefixtures("blender", "opened")
def test_a_patch_must_be_picked_for_its_signals(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="Click a spot on the body first"):
        bpy.ops.w2w.export_signals(directory=str(tmp_path))


@pytest.mark.usefixtures("blender", "opened")
def test_signals_that_are_gone_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signal_cache, "has", lambda _key: False)
    with pytest.raises(RuntimeError, match="The signals of 9 clips are gone"):
        bpy.ops.w2w.export_signals(directory=str(tmp_path / "new"), which="ALL")
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_the_report_and_the_rest_are_those_of_the_saved_folder(library: Path, tmp_path: Path) -> None:
    make_study(library)
    assert bpy.ops.w2w.export_report(filepath=str(tmp_path / "page.html")) == {"FINISHED"}
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    assert bpy.ops.w2w.export_table(filepath=str(tmp_path / "utility.csv")) == {"FINISHED"}
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "all"), which="ALL") == {"FINISHED"}
    assert CliRunner().invoke(APP, ["report", str(tmp_path / "saved")]).exit_code == 0
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "saved" / "report.html").read_bytes()
    assert (tmp_path / "utility.csv").read_bytes() == (tmp_path / "saved" / "utility.csv").read_bytes()
    for file in (tmp_path / "saved" / "signals").iterdir():
        assert (tmp_path / "all" / file.name).read_bytes() == file.read_bytes()


@pytest.mark.slow
def test_esc_ends_the_report_and_leaves_nothing(opened: bpy.types.Object, tmp_path: Path) -> None:
    opened.w2w.max_places = 1
    steps = report_steps(opened, tmp_path / "page.html")
    while next(steps).text != "writing page.html":
        pass
    steps.close()
    assert not list(tmp_path.glob("*.html"))


def test_nothing_can_be_exported_before_there_is_something(library: Path) -> None:
    for name in ("export_table", "export_report", "export_signals"):
        assert not getattr(bpy.ops.w2w, name).poll()
    make_study(library, "motions patches")
    for name in ("export_table", "export_report", "export_signals"):
        assert not getattr(bpy.ops.w2w, name).poll()
