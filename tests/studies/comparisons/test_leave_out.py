# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings tried on every set, and the page of what each gets from the others' choice."""

import json

import numpy as np
import pytest

from w2w.studies.comparisons.leave_out import try_settings, write_left_out
from w2w.studies.comparisons.truth import DATA_SETS
from w2w.studies.validation.tuning import SETTINGS, Result

ACTIONS, PEOPLE = ("a03", "a05", "a06"), ("s01", "s02", "s03", "s04")


def test_the_page_says_what_the_others_choose(tmp_path):
    high, low = Result(0.9, 0.8, 0.7, 0.0), Result(0.1, 0.2, float("nan"), 0.05)
    one, two = {"as fixed": low, "soft": high}, {"as fixed": high, "soft": low}
    page = write_left_out(tmp_path, {"one": one, "two": two})
    worse, better = "0.10, 0.20, nan, 0.050", "0.90, 0.80, 0.70, 0.000"
    assert f"| one | as fixed | {worse} | {worse} | {better} (soft) |" in page
    assert "| two | soft | 0.10, 0.20, nan, 0.050 |" in page
    content = json.loads((tmp_path / "left_out.json").read_text())
    assert content["one"]["chosen"] == "as fixed"
    assert content["one"]["settings"]["as fixed"]["cells"] is None
    assert page == (tmp_path / "left_out.md").read_text()


@pytest.mark.slow
def test_settings_are_tried_on_real_files(shared_data, tmp_path):
    whole = np.load(shared_data / "imu" / "berkeley_mhad" / "acc.npz", allow_pickle=False)
    names = [n for n in whole.files if n[:3] in PEOPLE and n[4:7] in ACTIONS and n[8:11] in ("r01", "r02")]
    np.savez(tmp_path / "few.npz", **{name: whole[name] for name in names})
    chosen = (SETTINGS[0], SETTINGS[4], SETTINGS[6])
    library = shared_data / "bvh" / "bandai_namco"
    found = try_settings(DATA_SETS["mhad"], tmp_path / "few.npz", [library], 0, chosen)
    assert list(found) == ["as fixed", "soft tissue of 6 Hz", "sources apart"]
    assert all(-1 <= one.mean_rho <= 1 and 0 <= one.regret <= 1 for one in found.values())
    assert found["as fixed"] != found["soft tissue of 6 Hz"]
    assert found["as fixed"] == found["sources apart"]  # there is one source
