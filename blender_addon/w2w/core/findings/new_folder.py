# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder for a study that no run has made, as `w2w run` would have left it."""

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ..files import new_folder, write_json
from ..imu.cover import FITTED, Cover, save_covers
from ..motion.motion import Motion
from ..study.clip_files import WORK, ClipWindows, features_file, motion_file, signals_file
from ..study.results import Study, StudyResults, stored_recording
from .summary import config_content, write_results

FOLDERS = ("motions", "signals", f"{WORK}/features")


def write_folder(
    folder: Path,
    study: Study,
    motions: Sequence[Motion | None],
    covers: Mapping[str, Cover],
    progress: Callable[[float], None],
) -> None:
    """Write a results folder, new or empty, whole or not at all.

    The study's clips have the names of the new files; its results know where their signals are now.
    `motions` holds one entry per clip, None if the body was moved otherwise; `covers` are the config's.
    `progress` is given the fraction done; an exception from it ends the work.
    """
    check_new(folder)
    old, clips = study.results, []
    with new_folder(folder) as out:
        for name in FOLDERS:
            (out / name).mkdir(parents=True)
        if covers:
            save_covers(out / FITTED, covers, [""] * len(covers))
        for number, (result, motion, place) in enumerate(zip(study.clips, motions, old.places, strict=True)):
            progress(number / len(motions))
            clip = result.clip
            if motion is not None:
                motion.save(motion_file(out, clip.name))
            labels = (clip.activity, clip.subject, clip.name)
            stored_recording(*place).labelled(old.patches.names, *labels).save(signals_file(out, clip.name))
            shutil.copyfile(features_file(*place), features_file(out, clip.name))
            windows = ClipWindows.read(out, clip.name)
            counts = {"windows": len(windows.is_test), "test_windows": int(windows.is_test.sum())}
            clips.append(replace(result, details={**result.details, **counts}))
        results = StudyResults(out, old.patches, old.clips, old.parameters, old.utility)
        write_findings(replace(study, clips=tuple(clips), results=results))


def write_findings(study: Study) -> None:
    """Write a results folder but for the clips' files: body, patches, ranking, choice, parameters."""
    out = study.results.out
    study.body.save(out / WORK / "body.npz")
    study.results.patches.save(out / WORK / "patches.npz")
    write_results(study)
    write_json(out / "config.json", config_content(study))


def check_new(folder: Path) -> None:
    """Raise a ValueError if a folder for results holds something."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"{folder} is not empty: choose a new folder for the results")
