# SPDX-License-Identifier: GPL-3.0-or-later
"""What is worn is read from the command line, refused in a sentence, and fitted before the first clip."""

import numpy as np
import pytest

from w2w.core.imu.cover import FITTED, load_covers
from w2w.core.patches.patches import sample_patches
from w2w.core.study.clip_files import WORK
from w2w.core.study.config import StudyConfig
from w2w.headless.runs.covers import fit_covers, parse_garments


def test_garments_are_listed_the_outer_first(tmp_path):
    (tmp_path / "my.blend").write_bytes(b"")
    own = f"{tmp_path}/my.blend:Hoodie"
    assert parse_garments(f" {own}, trousers ,") == (own, "trousers")
    assert parse_garments("") == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("skirt", "there is no garment called 'skirt': write tshirt, trousers or FILE.blend:OBJECT"),
        ("tshirt,tshirt", "'tshirt' is given twice"),
        ("no.blend:Coat", r"there is no file no\.blend"),
        ("my.blend", r"say which object of my\.blend is worn: my\.blend:OBJECT"),
    ],
)
def test_what_cannot_be_worn_is_said(text, message):
    with pytest.raises(ValueError, match=f"--garment: {message}"):
        parse_garments(text)


def test_an_object_must_be_named(tmp_path):
    (tmp_path / "my.blend").write_bytes(b"")
    with pytest.raises(ValueError, match=r"say which object of .*my\.blend is worn"):
        parse_garments(f"{tmp_path}/my.blend:")


def test_what_is_covered_stands_in_the_work_folder(tmp_path, bundled_body):
    (tmp_path / WORK).mkdir()
    patches = sample_patches(bundled_body, n=48)
    fit_covers(StudyConfig(garments=("tshirt", "trousers")), bundled_body, patches, tmp_path)
    covers = load_covers(tmp_path / FITTED)
    assert list(covers) == ["tshirt", "trousers"]
    assert not np.intersect1d(covers["tshirt"].patches, covers["trousers"].patches).size
    fit_covers(StudyConfig(), bundled_body, patches, tmp_path)
    assert not (tmp_path / FITTED).exists()
