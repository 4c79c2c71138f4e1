# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w validate own`: recordings of one's own, or of a data set, against the sites of a simulated study."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.command_line import cli
from w2w.core.imu.recordings import Recordings
from w2w.core.study.results import StudyResults
from w2w_studies.comparisons.by_protocol import compare_worn
from w2w_studies.comparisons.own import Names, against_run, own_protocol

PLACES = ("left upper arm", "left calf", "throat", "right calf", "left forearm")
NONE = Names({}, {})


@pytest.fixture(scope="module")
def study(door):
    return StudyResults.load(door / "RESULTS")


def worn(study, moved=0):
    """What the study's own sensors record, called by its places, or each by that `moved` places on."""
    from w2w_studies.comparisons.unpaired import patches_at_site

    patches = [patches_at_site(place, study.patches, study.body())[0] for place in PLACES]
    patches = patches[moved:] + patches[:moved]
    recordings = []
    for number in range(len(study.clips)):
        made = study.recording(number, patches)
        recordings.append(replace(made, sites=PLACES))
    return Recordings(recordings)


def compared(study, recordings, names=NONE):
    protocol, simulate = against_run(own_protocol(recordings, study, names), recordings, study)
    (found,) = compare_worn(protocol, recordings, simulate)
    return found


@pytest.mark.later
def test_the_studys_own_signals_agree_with_it(study):
    found = compared(study, worn(study))
    assert found.validation.sites == PLACES
    assert found.validation.overall.spearman > 0.7
    assert found.validation.regret.lost < 0.05
    assert abs(found.validation.level.value) < 0.1
    assert [bar.what for bar in found.bars] == ["regret", "rho over ceiling"]


@pytest.mark.later
def test_places_called_by_each_others_names_do_not(study):
    right, wrong = (compared(study, worn(study, moved)).validation for moved in (0, 1))
    assert wrong.mean_rho < right.mean_rho - 0.3


@pytest.mark.later
def test_other_names_are_told_by_tables(study, tmp_path):
    recordings = [
        replace(one, sites=("my glove", *PLACES[1:]), activity=f"{one.activity}s") for one in worn(study)
    ]
    renamed = Recordings(recordings)
    with pytest.raises(ValueError, match="fewer than two activities are recorded and simulated"):
        compared(study, renamed)
    (tmp_path / "sites.csv").write_text("place,site\nmy glove,left upper arm\n")
    (tmp_path / "activities.csv").write_text(
        "recorded,simulated\nwavings,waving\nkickings,kicking\nstirrings,stirring\n"
    )
    names = Names.read(tmp_path / "sites.csv", tmp_path / "activities.csv")
    found = compared(study, renamed, names)
    assert found.validation.sites[0] == "my glove"
    assert found.validation.real.activities == ("kicking", "stirring", "waving")
    with pytest.raises(ValueError, match="the recordings have no 'belt'; there are my glove"):
        own_protocol(renamed, study, Names({"belt": "waist"}, {}))
    with pytest.raises(ValueError, match="the study has no 'flying'; there are kicking"):
        own_protocol(renamed, study, Names({}, {"wavings": "flying"}))
    with pytest.raises(ValueError, match=r'^no placement, sensor site or region is called "moon"'):
        compared(study, worn(study), Names({PLACES[0]: "moon"}, {}))


@pytest.mark.later
def test_the_command_writes_the_report_of_the_data_sets(study, door, tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    for one in worn(study):
        one.save(folder / f"{one.clip}.npz")
    code, output = cli("validate", "own", door / "RESULTS", folder, "--out", tmp_path / "out")
    assert code == 0, output
    report = (tmp_path / "out" / "report.md").read_text()
    assert "| regret <= 0.03 |" in report
    assert "people's, the mean over sites" in report
    assert "trained on simulated" not in report
    content = json.loads((tmp_path / "out" / "validation_all_activities.json").read_text())
    assert set(content["sites"]) == set(PLACES)
    assert np.isfinite(content["simulated_above_real"]["value"])


def test_what_is_wrong_gets_a_sentence(door, tmp_path):
    given = ["validate", "own", door / "RESULTS", tmp_path, "--out", tmp_path / "out"]
    code, output = cli(*given)
    assert (code, "can be used: it holds no" in output) == (2, True)
    code, output = cli(*given, "--as", "nothing")
    assert (code, "--as must be mhad, umafall, dsads, upfall, not nothing" in output) == (2, True)
    code, output = cli(*given, "--as", "upfall", "--sites", tmp_path / "sites.csv")
    assert (code, "--as has names of its own" in output) == (2, True)
