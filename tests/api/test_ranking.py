# SPDX-License-Identifier: GPL-3.0-or-later
"""`import w2w`: signals, and a ranking in a few calls."""

import html
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sklearn.dummy import DummyClassifier
from sklearn.linear_model import Ridge
from sklearn.neighbors import KNeighborsClassifier

import w2w
from w2w.core.patches.body_parts import find_patches
from w2w.core.patches.naming import place
from w2w.core.ranking.weights import mean_over
from w2w.core.selection.headline import short
from w2w_studies.paper.joint_test import multi_sensor_check
from w2w_studies.paper.subsets import counted_columns, exact_subset, greedy_subset

from ..clip_lists import skipped_clips
from ..command_line import cli
from ..here import clips_here
from ..made_door import ARM, LEG, moving
from ..rings import by_day

pytestmark = pytest.mark.usefixtures("few_orders")


def test_signals_without_a_band_limit_are_warned_of(signals, few):
    settings = w2w.Synthesis(cutoff_hz=None)
    with pytest.warns(UserWarning, match="motion above half the sensor rate is folded back"):
        w2w.synthesize(signals.motions[:1], few, settings=settings)


def test_labels_come_from_the_csv(signals):
    assert [recording.activity for recording in signals][::4] == ["kicking", "stirring", "waving"]
    assert {recording.subject for recording in signals} == {"person 0", "person 1"}


def test_what_moves_recognises(ranking):
    assert ranking.f1.shape == (24, 3)
    regions = np.array(ranking.patches.regions)
    arms = np.flatnonzero([region.startswith("left") and "arm" in region for region in regions])
    head = find_patches(regions, ranking.names, "head")
    assert ranking.mean[arms].max() > 0.9
    assert ranking.mean[ranking.best] >= ranking.mean[head].max()
    kicking = ranking.activities.index("kicking")
    right_foot = find_patches(regions, ranking.names, "right foot")
    assert ranking.f1[arms, kicking].max() > ranking.f1[right_foot, kicking].min()


def test_a_place_far_from_every_patch_is_refused_and_one_near_enough_is_warned_of(ranking):
    with pytest.raises(ValueError, match=r"nearest patch to 'left ear' is 12\.5 cm away \(throat\), too far"):
        ranking.at("left ear")
    with pytest.warns(UserWarning, match=r"nearest patch to 'right wrist' is [5-9]\.\d cm away"):
        assert ranking.at("right wrist")


@pytest.mark.parametrize("n_placements", by_day((3,), (1, 3)))
def test_own_placements_are_ranked_by_their_names(library, tmp_path, n_placements):
    body = w2w.Body.bundled()
    wrist, ankle, ear = (place(name, body) for name in ("left wrist", "left ankle", "left ear"))
    placements = {"strap pod": wrist, "shoe clip": body.vertices[ankle], "hearing aid": int(ear)}
    own = w2w.patches_at(body, dict(list(placements.items())[:n_placements]))
    ranking = w2w.rank(w2w.synthesize(w2w.load(library), own), folds=2)
    assert ranking.names[ranking.best] == "strap pod"
    assert ranking.mean[ranking.best] > 0.6
    assert ranking.at("strap pod", ranking.names[-1]) == [0, n_placements - 1]
    if n_placements == 1:  # nothing lies between placements
        ranking.heatmap(tmp_path / "own.png")
    assert [row["name"] for row in ranking._rows()] == list(own.names)


@pytest.mark.slow
def test_labels_without_meaning_are_not_recognised(library, few, ranking):
    """The same signals under labels dealt by chance."""
    motions = w2w.load(library)
    dealt = np.random.default_rng(3).permutation([motion.activity for motion in motions])
    shuffled = tuple(
        motion.labelled(str(activity), "", motion.clip)
        for motion, activity in zip(motions, dealt, strict=True)
    )
    scores = w2w.rank(w2w.synthesize(replace(motions, motions=shuffled), few), folds=3).mean
    assert scores.mean() < 0.4 < ranking.mean.mean()
    assert scores.max() < 0.7


def test_the_papers_sets_are_chosen_and_tested_by_the_studies(ranking):
    f1 = counted_columns(ranking.utility.f1, ranking.utility.weights)
    chosen, exact = greedy_subset(f1, 0.99, 2), exact_subset(f1, 0.99, 2)
    assert exact.mean_max_after_each[-1] >= chosen.mean_max_after_each[-1] - 1e-6
    protocol = ranking.labels.protocol(ranking.config)
    maps = multi_sensor_check(chosen.order, ranking.inputs, protocol, ranking.classifier)
    assert len(maps) == len(chosen.order)
    assert maps[0].mean[0] == pytest.approx(ranking.mean[chosen.order[0]], abs=0.1)


def test_there_is_one_f1_and_it_is_that_in_a_stream(ranking):
    found, utility = ranking.answer, ranking.utility
    alone = utility.expected_mean + mean_over(utility.lost, utility.weights)
    assert mean_over(utility.lost, utility.weights) > 0
    assert (utility.expected_mean <= alone).all()
    assert found.in_stream
    assert found.f1.low <= found.f1.mean <= found.f1.high
    assert found.detail().startswith(f"F1 {short(found.f1.mean)} (")
    belt = next(score for score in found.products if score.name == "belt clip")
    assert ranking.compare("belt clip")[0].f1 == belt.f1
    assert ranking.stream.on_map(utility) is utility  # once is enough
    for score in found.products:  # what is shown subtracts
        assert round(score.cost.expected, 2) == pytest.approx(
            round(found.f1.mean, 2) - round(score.expected, 2), abs=1e-6
        )


@pytest.mark.slow
def test_windows_long_for_the_clips_are_warned_of(signals):
    with pytest.warns(UserWarning, match="windows of 20 s are .* times as long as the median clip"):
        w2w.rank(signals, window=20.0, folds=3)


@pytest.mark.slow
def test_a_set_is_chosen_to_be_worn_together(ranking):
    worn = ranking.wear_together(1.0, max_sensors=2, constraints=w2w.Constraints(forbid=("left",)))
    assert 1 <= len(worn.order) <= 2
    assert not any(ranking.patches.regions[patch].startswith("left") for patch in worn.order)
    assert worn.promise.mean[0] == pytest.approx(ranking.expected[worn.order[0]])
    assert "on other clips" in worn.sentence()
    with pytest.raises(ValueError, match="ridge"):
        replace(ranking, classifier="trees").wear_together()


def test_constraints_hold(ranking):
    free = ranking.wear_together(0.5, max_sensors=1)
    region = ranking.patches.regions[free.order[0]]
    other = ranking.wear_together(0.5, max_sensors=1, constraints=w2w.Constraints(forbid=(region,)))
    assert region not in {ranking.patches.regions[patch] for patch in other.order}


def test_activities_that_are_not_ranked_are_named(library, few, ranking):
    assert ranking.left_out == {}
    motions = w2w.load(library)
    short = moving(LEG, 1.0, 0)
    short = replace(short, rotations=short.rotations[:8], pelvis=short.pelvis[:8])
    more = (
        moving(ARM, 0.9, 3).labelled("bowing", "", "bow"),
        *(moving(LEG, 0.7, 9).labelled("stepping", "", f"step {copy}") for copy in "ab"),
        short.labelled("twitching", "", "twitch"),
    )
    every = replace(
        motions, motions=(*motions, *more), motion_keys=(*motions.motion_keys, "", "one", "one", "")
    )
    with pytest.warns(UserWarning, match="3 of 6 activities are not ranked") as told:
        found = w2w.rank(w2w.synthesize(every, few), folds=2)
    assert set(found.left_out) == {"bowing", "stepping", "twitching"}
    assert "only one clip" in found.left_out["bowing"]
    assert "too short" in found.left_out["twitching"]
    assert found.skipped[0][0] == "twitch"
    (warning,) = told
    assert warning.filename == __file__
    assert "bowing, stepping: each has only one clip" in str(warning.message)
    assert "step b (of step a)" in str(warning.message)


def test_subjects_are_left_out_one_at_a_time(signals):
    assert w2w.rank(signals, by_subject=True).utility.protocol == "leave one of 2 subjects out"


def test_a_motion_of_two_subjects_is_warned_of_and_tested_with_the_first(few):
    made = [moving(joints, 1.0, number) for joints in (ARM, LEG) for number in range(4)]
    labels = [
        (name, f"person {number % 2}", f"{name} {number}") for name in ("a", "b") for number in range(4)
    ]
    motions = [one.labelled(*label) for one, label in zip(made, labels, strict=True)]
    motions.append(replace(made[0].labelled("a", "person 1", "copy"), rate=30.5))
    with pytest.warns(UserWarning, match="2 clips of person 0 and person 1 show the same motion"):
        ranking = w2w.rank(w2w.synthesize(motions, few, sensor="ideal"), by_subject=True)
    assert ranking.utility.protocol == "leave one of 2 subjects out"


@pytest.mark.slow
def test_an_own_estimator_ranks_by_features_or_windows(signals):
    by_features = w2w.rank(signals, folds=2, classifier=w2w.EstimatorClassifier(KNeighborsClassifier(1)))
    assert by_features.mean.max() > 0.9
    flat = w2w.EstimatorClassifier(Flattened(), inputs="windows")
    assert w2w.rank(signals, folds=2, classifier=flat).utility.classifier == "Flattened"
    blind = w2w.rank(signals, folds=2, classifier=DummyClassifier())
    assert blind.mean.max() < 0.3


class Flattened:
    """An estimator that scikit-learn cannot clone and whose fit returns nothing."""

    def fit(self, windows, labels):
        assert windows.shape[2] == 6
        self.model = KNeighborsClassifier(1).fit(windows.reshape(len(windows), -1), labels)

    def predict(self, windows):
        return self.model.predict(windows.reshape(len(windows), -1))


def test_what_is_no_estimator_is_said():
    with pytest.raises(ValueError, match="has no method 'fit'"):
        w2w.EstimatorClassifier(np.random.default_rng())
    with pytest.raises(ValueError, match='must be "features" or "windows"'):
        w2w.EstimatorClassifier(DummyClassifier(), inputs="signals")


POSES, STILL = np.zeros((60, 72)), np.zeros((60, 3))
JOINTS, FACTS = np.zeros((60, 24, 3)), w2w.PoseFacts(rate=30)

WRONG = {
    "an unknown classifier": (
        lambda s, _: w2w.rank(s, classifier="forest"),
        "there are ridge, multi3net, trees",
    ),
    "an estimator's class": (
        lambda *_: w2w.EstimatorClassifier(DummyClassifier),
        r"DummyClassifier\(\.\.\.\)",
    ),
    "no classifier": (lambda s, _: w2w.rank(s, classifier=None), "not None"),
    "a class": (lambda s, _: w2w.rank(s, classifier=w2w.EstimatorClassifier), "made first"),
    "a list": (lambda s, _: w2w.rank(list(s)), "synthesize"),
    "motions": (lambda s, _: w2w.rank(s.motions), "synthesize"),
    "no signals": (lambda s, _: w2w.rank(s[:0]), "one clip at least"),
    "half a fold": (lambda s, _: w2w.rank(s, folds=2.5), "whole number"),
    "one background": (lambda s, _: w2w.rank(s, background="waving"), "a list of activities"),
    "weights by list": (lambda s, _: w2w.rank(s, weights=["waving"]), "give each a number"),
    "a weight in words": (lambda s, _: w2w.rank(s, weights={"waving": "3"}), "weight of 'waving'"),
    "no sensor": (lambda s, _: w2w.synthesize(s.motions, s.patches, sensor=None), "not None"),
    "a sensor's file": (
        lambda s, _: w2w.synthesize(s.motions, s.patches, sensor=Path("a.json")),
        "read_sensor",
    ),
    "a number of patches": (lambda s, _: w2w.synthesize(s.motions, 16), "sample_patches"),
    "no motions": (lambda s, _: w2w.synthesize([], s.patches), "no motion to record"),
    "a folder": (lambda s, _: w2w.synthesize("MY_CLIPS", s.patches), "no motion to record"),
    "no target": (lambda _, r: r.wear_together(0), "from 0.01 to 1, not 0"),
    "not a number": (lambda _, r: r.wear_together(float("nan")), "not nan"),
    "percent": (lambda _, r: r.wear_together(90), "from 0.01 to 1, not 90"),
    "percent of each": (lambda _, r: r.wear_together(0.9, every_activity=90), "from 0 to 1, not 90"),
    "half a sensor": (lambda _, r: r.wear_together(0.9, max_sensors=1.5), "max_sensors must be a whole"),
    "a wish": (lambda *_: w2w.Constraints(forbid="head"), "list of words"),
    "a number's wish": (lambda *_: w2w.Constraints(must=(3,)), "list of words"),
    "costs by name": (lambda *_: w2w.Constraints(costs={"leg": 2.0}), "pairs such as"),
    "costs in words": (lambda *_: w2w.Constraints(costs=(("leg", "2"),)), "pairs such as"),
    "wishes by name": (lambda _, r: r.wear_together(constraints={"forbid": ["head"]}), "Constraints"),
    "several at once": (lambda _, r: r.at(["left wrist"]), "a placement is a name"),
    "a patch too many": (lambda _, r: r.table([24]), "from 0 to 23, not 24"),
    "a patch from the end": (lambda _, r: r.table([-1]), "from 0 to 23, not -1"),
    "a patch's name": (lambda _, r: r.table(["left wrist"]), "not 'left wrist'"),
    "a body's name": (lambda *_: w2w.load("MY_CLIPS", body="female"), "not 'female'"),
    "facts by name": (lambda *_: w2w.load("MY_CLIPS", pose={"rate": 30}), "PoseFacts"),
    "half a patch": (lambda *_: w2w.sample_patches(w2w.Body.bundled(), 2.5), "whole number"),
    "a gender in words": (lambda *_: w2w.shaped(w2w.Body.bundled(), gender="female"), "between -1 and 1"),
    "labels by name": (lambda *_: w2w.load("MY_CLIPS", labels={}), "by its path, not by dict"),
    "a list of files": (lambda *_: w2w.load(["a.bvh"]), "by its path, not by list"),
    "an array": (lambda *_: w2w.load(np.zeros((9, 24, 3))), "by its path, not by ndarray"),
    "a map of bones": (lambda *_: w2w.load("MY_CLIPS", bone_maps={"hip": "pelvis"}), "a list of BoneMap"),
    "places in a list": (lambda _, r: r.compare(["ring"]), r"compare\('ring', 'left ankle'\)"),
    "nothing to compare": (lambda _, r: r.compare(), "each for itself"),
    "a place, not a list": (lambda *_: list(w2w.stream("RESULTS", "left toes")), "not 'left toes'"),
    "a part too many": (lambda *_: list(w2w.stream("RESULTS", None, 2, 2)), "not 2 of 2"),
    "a ranking": (lambda _, r: w2w.open_results(r), "by its path, not by Ranking"),
    "a window in words": (lambda s, _: w2w.rank(s, window="2"), "seconds, not '2'"),
    "a bar": (lambda s, _: w2w.rank(s, progress=True), "a function that is given the fraction"),
    "a background of numbers": (lambda s, _: w2w.rank(s, background=[3]), "a name is text"),
    "a rate in words": (lambda s, _: w2w.synthesize(s.motions, s.patches, rate="50"), "number, not '50'"),
    "settings by name": (
        lambda s, _: w2w.synthesize(s.motions, s.patches, settings={"rate_hz": 50}),
        "settings is a Synthesis",
    ),
    "patches first": (lambda s, _: w2w.synthesize(s.patches, s.motions), "motions come first"),
    "one patch": (lambda _, r: r.table(3), "takes a list of patches"),
    "words for patches": (lambda _, r: r.table("left toes"), "takes a list of patches"),
    "a file of nothing": (lambda *_: w2w.read_recording(None), "by its path, not by NoneType"),
    "one recording": (lambda s, _: w2w.Recordings(s[0]), "give a list of ImuRecording"),
    "a fast pose": (lambda *_: w2w.PoseFacts(rate="fast"), "not 'fast'"),
    "a list of placements": (lambda *_: w2w.patches_at(w2w.Body.bundled(), ["pod"]), "strap pod"),
    "signals by name": (lambda s, _: s["waving 0"], "by number or slice"),
    "motions by name": (lambda s, _: s.motions["waving"], "by number or slice"),
    "a motion by number": (lambda *_: w2w.Motion.load(3), "by its path, not by int"),
    "a body by number": (lambda *_: w2w.Body.load(3), "by its path, not by int"),
    "a sensor by number": (lambda *_: w2w.read_sensor(3), "by its path, not by int"),
    "an empty path": (lambda *_: w2w.load(""), "this one is empty"),
    "no bone maps": (lambda *_: w2w.load("MY_CLIPS", bone_maps=None), "a list of BoneMap"),
    "people in words": (lambda s, _: w2w.rank(s, by_subject="yes"), "must be True or False"),
    "no target at all": (lambda _, r: r.wear_together(None), "from 0.01 to 1, not None"),
    "no least F1": (lambda _, r: r.wear_together(0.9, None), "from 0 to 1, not None"),
    "a picture by number": (lambda _, r: r.heatmap(3), "by its path, not by int"),
    "a report by number": (lambda _, r: r.report(3), "by its path, not by int"),
    "joints on a gender": (lambda *_: w2w.from_joints(JOINTS, FACTS, body="female"), "must be a Body"),
    "joints of two lengths": (lambda *_: w2w.from_joints([JOINTS, JOINTS[:3]], FACTS), "array of numbers"),
    "joints by name": (lambda *_: w2w.from_joints({"hip": JOINTS}, FACTS), "array of numbers"),
    "the joints' file": (lambda *_: w2w.from_joints("joints.npy", FACTS), "array of numbers"),
    "half a person": (lambda *_: w2w.PoseFacts(person="a"), "counted from 1 on"),
    "several sets": (lambda *_: w2w.PoseFacts(joint_set=["smpl-24"]), "must be one of"),
    "a rate of poses": (lambda *_: w2w.from_smpl(POSES, STILL, "30"), "frames a second"),
    "no rate": (lambda *_: w2w.from_smpl(POSES, STILL, None), "do not say it"),
    "up by number": (lambda *_: w2w.from_smpl(POSES, STILL, 30, up=2), "must be one of x, y, z"),
    "poses on a gender": (lambda *_: w2w.from_smpl(POSES, STILL, 30, body="male"), "must be a Body"),
    "one placement": (lambda *_: list(w2w.stream("RESULTS", 3)), "a list of names"),
    "a recording last": (lambda *_: w2w.write_recording("a.csv", "b.csv"), "then an ImuRecording"),
    "a band in words": (lambda *_: w2w.Synthesis(cutoff_hz="10"), "must be positive"),
    "a shape by name": (lambda *_: w2w.shaped("female"), "takes a Body"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_a_value_error_that_says_what_to_change(
    signals, ranking, library, monkeypatch, case
):
    monkeypatch.chdir(library.parent)
    call, sentence = WRONG[case]
    with pytest.raises(ValueError, match=sentence):
        call(signals, ranking)


def test_a_part_of_motions_or_signals_is_used_like_the_whole(signals, ranking):
    motions = replace(signals.motions, motion_keys=tuple(f"key {n}" for n in range(len(signals))))
    assert motions[3:5].motion_keys == ("key 3", "key 4")
    assert motions[3:5].body is motions.body
    part = signals[4:]
    assert len(part) == len(part.motions) == len(signals) - 4
    assert part[0].clip == signals[4].clip
    assert w2w.rank(part, folds=2).activities == ranking.activities[1:]


def test_patches_of_another_body_are_refused(library, few):
    wrong = replace(few, labels=few.labels[:-1])
    with pytest.raises(ValueError, match="sample patches on the motions' body"):
        w2w.synthesize(w2w.load(library), wrong)


def test_an_unknown_activity_has_no_heatmap(ranking, tmp_path):
    with pytest.raises(ValueError, match="'flying' was not ranked; there are kicking, stirring, waving"):
        ranking.heatmap(tmp_path / "map.png", "flying")


@pytest.mark.slow
def test_a_heatmap_is_drawn_without_blender(ranking, tmp_path):
    from matplotlib.image import imread

    ranking.heatmap(tmp_path / "mean.png")
    ranking.heatmap(tmp_path / "again.png")
    assert (tmp_path / "mean.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    ranking.heatmap(tmp_path / "raw.png", expected=False)
    assert (tmp_path / "mean.png").read_bytes() != (tmp_path / "raw.png").read_bytes()
    ranking.heatmap(tmp_path / "kicking.png", "kicking")
    mean, kicking = (imread(tmp_path / name)[..., :3] for name in ("mean.png", "kicking.png"))
    coloured = np.ptp(mean, axis=2) > 0.15
    assert coloured.mean() > 0.03
    assert np.abs(mean - kicking)[coloured].mean() > 0.01


def test_a_notebook_shows_rows_as_a_table(ranking):
    rows = ranking._rows([0, 1])
    shown = rows._repr_html_()
    assert shown.count("<tr>") == 3
    assert f"<td>{rows[1]['mean']:.3f}" in shown
    assert shown.count("<th>") == shown.count("<td>") / 2 == len(rows[0])
    assert rows == list(rows)
    assert ranking._rows([])._repr_html_() == "<table><tr></table>"


def test_where_pandas_is_installed_the_table_is_its_own(ranking, tmp_path):
    pandas = pytest.importorskip("pandas")
    found = ranking.table([0, 1])
    assert isinstance(found, pandas.DataFrame)
    ranking.to_csv(tmp_path / "f1.csv")
    assert list(found.columns) == list(pandas.read_csv(tmp_path / "f1.csv").columns)
    assert found["mean"].tolist() == pytest.approx(ranking.mean[:2])


@pytest.mark.slow
def test_background_and_weights_decide_the_mean(signals, ranking):
    found = w2w.rank(signals, folds=3, background=["stirring"], weights={"waving": 2.0})
    names = list(found.activities)
    shares = np.array([{"stirring": 0.0, "waving": 2 / 3}.get(name, 1 / 3) for name in names])
    np.testing.assert_array_equal(found.f1, ranking.f1)
    np.testing.assert_allclose(found.mean, found.f1 @ shares, rtol=1e-5)
    worn = found.wear_together(target=1.0, max_sensors=2)
    np.testing.assert_allclose(worn.promise.mean, worn.promise.f1 @ shares, atol=0.05)
    with pytest.raises(ValueError, match="no clip is labelled jumping"):
        w2w.rank(signals, background=["jumping"])


@pytest.mark.slow
def test_what_a_notebook_shows_is_short_or_a_page(signals, ranking):
    for shown in (ranking, signals, signals[0], signals.motions, signals.motions[0], signals.patches):
        assert len(repr(shown)) < 150
    assert len(repr(signals.motions.body)) + len(repr(ranking.utility)) < 300
    page = ranking._repr_html_()
    assert page.startswith(f"<p><b>{html.escape(ranking.answer.sentence())}</b>")
    assert "data:image/png;base64,iVBOR" in page
    assert ranking.heatmap().get_size_inches().min() > 1


def test_windows_of_ten_minutes_refuse_the_same_clips_as_on_the_command_line(signals, library, tmp_path):
    words = "s, shorter than the 12 s a window needs"
    with pytest.raises(ValueError, match=f"no clip gives a window of 600 s: clip '.*{words}"):
        w2w.rank(signals, window=600)
    options = "--window 600 --patches 4 --workers 1 --no-pictures --no-report".split()
    with clips_here():
        code, _ = cli("run", library, "--labels", library.parent / "labels.csv", "--out", tmp_path, *options)
    assert code == 1
    reasons = skipped_clips(tmp_path)
    assert len(reasons) >= len(signals)
    assert all(words in reason for reason in reasons.values() if "damaged" not in reason), reasons


def test_a_report_of_a_results_folder_is_that_of_the_command_line(door, tmp_path):
    w2w.open_results(door / "RESULTS").report(tmp_path / "report.html")
    assert cli("report", door / "RESULTS")[0] == 0
    written = door / "RESULTS" / "report.html"
    assert (tmp_path / "report.html").read_bytes() == written.read_bytes()
    written.unlink()


@pytest.mark.slow
def test_a_report_of_a_ranking_says_what_was_ranked(library, few, tmp_path):
    """The answer, the sensor, the rate and the clips that the ranking is of."""
    narrow = replace(w2w.preset("bmi270"), name="my part")
    motions = w2w.load(library, labels=library.parent / "labels.csv")
    own = w2w.rank(w2w.synthesize(motions, few, narrow, rate=40.0), folds=3)
    own.report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert own.answer.sentence().split(" (")[0] in page
    assert "12 of 12 clips ranked, in 3 activities" in page
    assert "<td>my part, 40.0 Hz</td>" in page


def test_findings_display_as_sentences(ranking):
    worn, (score,) = ranking.wear_together(0.9), ranking.compare("left toes")
    for shown, sentence in (
        (ranking.answer, ranking.answer.sentence()),
        (worn, worn.sentence()),
        (score, "left toes: F1 "),
        (ranking.advice.cards[0], ranking.advice.cards[0].in_words()),
    ):
        assert repr(shown).startswith(f"<{type(shown).__name__}: {sentence}")
        assert html.escape(sentence) in shown._repr_html_()


@pytest.mark.slow
def test_a_heatmap_shows_its_picture_in_a_notebook(ranking):
    assert ranking.heatmap()._repr_png_().startswith(b"\x89PNG")


def test_parts_of_a_stream_are_each_clip_once(library):
    folder = library.parent / "RESULTS"
    whole = [recording.clip for recording in w2w.stream(folder, ["left toes"])]
    parts = [[one.clip for one in w2w.stream(folder, ["left toes"], part, 3)] for part in range(3)]
    assert sorted(clip for part in parts for clip in part) == sorted(whole)
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_messages_name_parameters_of_python(tmp_path, shared_cases):
    np.savez(tmp_path / "walk.npz", poses=np.zeros((40, 72)), trans=np.zeros((40, 3)))
    with pytest.raises(ValueError, match=r"give pose=PoseFacts\(rate=\.\.\.\)") as told:
        w2w.load(tmp_path / "walk.npz")
    assert "--" not in str(told.value)
    with pytest.raises(ValueError, match=r"give rate=\.\.\., .*or save it again"):
        w2w.Motion.load(tmp_path / "walk.npz")
    with pytest.raises(ValueError, match=r"^pose=PoseFacts\(person=\.\.\.\) chooses among people"):
        w2w.load(shared_cases / "tpose_at_end.bvh", pose=w2w.PoseFacts(person=2))


def test_what_blender_calls_is_no_name_for_others():
    assert not {"register", "unregister"} & {*w2w.__all__, *dir(w2w)}
    assert callable(w2w.register)


@pytest.mark.slow
def test_a_loader_with_two_workers_gives_every_window_once(library, torch, monkeypatch):
    """The example of the documents."""
    monkeypatch.chdir(library.parent)
    text = (Path(__file__).resolve().parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
    names = {"w2w": w2w, "torch": torch}
    code = text[text.index("class Windows(") :].partition("```")[0]
    exec(code.replace("left wrist", "left toes").replace("sternum", "throat"), names)
    alone, two = (
        torch.utils.data.DataLoader(names["Windows"](), batch_size=None, num_workers=workers)
        for workers in (0, 2)
    )
    assert sorted(activity for _, activity in two) == sorted(activity for _, activity in alone)


def test_a_ranking_in_memory_is_saved_and_says_what_a_sensor_needs(ranking, tmp_path):
    ranking.save(tmp_path / "OUT")
    again = w2w.open_results(tmp_path / "OUT")
    assert again.answer.sentence() == ranking.answer.sentence()
    np.testing.assert_array_equal(again.f1, ranking.f1)
    place = ranking.names[ranking.best]
    assert repr(ranking.needs(place)) == repr(again.needs(place))
    assert repr(ranking.needs(place)).startswith(f"<Need of {place}: ")
    recordings = list(w2w.stream(tmp_path / "OUT", [place]))
    assert [one.clip for one in recordings] == [clip.name for clip in ranking.clips]
    with pytest.raises(ValueError, match="not empty"):
        ranking.save(tmp_path / "OUT")
    with pytest.raises(ValueError, match="others lie in a folder"):
        again.save(tmp_path / "again")


def test_what_cannot_be_ranked_is_said_in_a_sentence(signals):
    with pytest.raises(ValueError, match="window must be a positive number"):
        w2w.rank(signals, window=-1)
    with pytest.raises(ValueError, match=r"stride must be in \(0, window = 2.0\]"):
        w2w.rank(signals, stride=5)
    with pytest.raises(ValueError, match="is a regressor: activities need a classifier"):
        w2w.rank(signals, classifier=Ridge())
    unlabelled = [motion.labelled("", "", "") for motion in signals.motions]
    with pytest.raises(ValueError, match="no motion says its activity"):
        w2w.rank(w2w.synthesize(unlabelled, signals.patches))
