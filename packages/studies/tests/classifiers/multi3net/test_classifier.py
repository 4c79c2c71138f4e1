# SPDX-License-Identifier: GPL-3.0-or-later
"""Multi3Net's IMU branch: together as alone, stopped apart, taken up again, never shown the tested fold."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.classifiers.multi3net.classifier import Multi3Net, split_windows

SMALL = Multi3Net(
    width=8, hidden=16, embedding=8, spectrum=6, batch_size=16, epochs=12, patience=12, learning_rate=0.005
)
STOPPING = replace(SMALL, early_stopping=True)
WAYS = pytest.mark.parametrize("settings", [SMALL, STOPPING], ids=["all epochs", "stopping"])


def library(n_clips=24, n_classes=3, n_places=4, samples=20, seed=0):
    """Swings of a tempo by class, two windows a clip; the noise grows from place to place."""
    rng = np.random.default_rng(seed)
    clip = np.repeat(np.arange(n_clips), 2)
    labels = clip % n_classes
    time = np.arange(samples)[:, None] / samples
    phase = rng.uniform(0, 0.4, (len(clip), 1, 1, 6))
    swing = np.sin(2 * np.pi * (labels[:, None, None, None] + 1) * time + phase)
    noise = (
        rng.normal(size=(len(clip), n_places, samples, 6)) * np.geomspace(0.1, 20, n_places)[:, None, None]
    )
    return (3 * swing + noise).astype(np.float32), labels, clip // n_classes % 4, clip


def parts(torch, places, settings=SMALL, dtype=None):
    """What `train` takes, for some places of the library."""
    from w2w_studies.classifiers.multi3net.network import Examples, Network

    windows, labels, fold, _ = library()
    windows = windows[:, places].astype(dtype or np.float32)
    learn, validation = split_windows(labels, fold, 0, settings.early_stopping)
    examples = Examples.prepare(windows, labels, learn, validation, "cpu", settings.spectrum)
    sizes = (examples.windows.shape[2], 6, 3, settings.width, settings.hidden, settings.embedding)
    return Network(*sizes), examples, settings, generator(torch)


def generator(torch):
    return lambda epoch: torch.Generator().manual_seed(100 + epoch)


@pytest.mark.slow
@WAYS
def test_learns_what_it_can_and_finds_noise_harder(settings):
    pytest.importorskip("torch")
    windows, labels, fold, _ = library()
    named = replace(settings, epochs=12).predict_folds(windows, labels, fold, np.ones(len(labels), bool))
    right = (named == labels[:, None]).mean(axis=0)
    assert right[0] > 0.9
    assert right[3] < right[0] - 0.2


@pytest.mark.parametrize(
    "settings",
    [SMALL, replace(STOPPING, lr_patience=1), replace(STOPPING, lr_patience=1, patience=2)],
    ids=["all epochs", "slowing down", "stopping"],
)
def test_a_place_among_others_is_trained_as_alone(torch, settings):
    """In double precision, dropout and blending on, whether or not others stop before it."""
    from w2w_studies.classifiers.multi3net.training import train

    network, examples, schedule, draws = parts(torch, [0, 1, 2, 3], settings, np.float64)
    together = train(network, examples, schedule, draws)
    if settings.patience == 2:
        assert len(set(together.epochs.tolist())) > 1
    for place in range(4):
        network, examples, schedule, draws = parts(torch, [place], settings, np.float64)
        alone = train(network, examples, schedule, draws)
        torch.testing.assert_close(alone.best[0], together.best[place], rtol=1e-9, atol=1e-11)
        assert alone.epochs[0] == together.epochs[place]


def test_single_precision_is_the_same_within_rounding(torch):
    from w2w_studies.classifiers.multi3net.training import train

    settings = replace(SMALL, epochs=5)
    together = train(*parts(torch, [0, 1, 2, 3], settings))
    alone = train(*parts(torch, [2], settings))
    torch.testing.assert_close(alone.weights[0], together.weights[2], rtol=1e-3, atol=1e-5)


@pytest.mark.slow
def test_group_size_changes_nothing_but_rounding():
    pytest.importorskip("torch")
    windows, labels, fold, _ = library()
    is_test = np.ones(len(labels), bool)
    named = [
        replace(SMALL, group=group, epochs=3).predict_folds(windows, labels, fold, is_test)
        for group in (1, 3, 4)
    ]
    assert len(np.unique(named[2])) > 1
    assert (named[0] == named[2]).mean() > 0.98
    assert (named[1] == named[2]).mean() > 0.98


def test_a_gpu_trains_as_many_patches_at_once_as_fit_and_a_cpu_few(torch, monkeypatch):
    """A patch of 1,500 windows took 10.4 GiB / 512 on one."""
    from w2w_studies.classifiers.multi3net.group import portions

    shape, patch = (1500, 512, 100, 6), 4 * 1500 * 100 * 6
    free = 16 * 2**30
    monkeypatch.setattr(torch.cuda, "mem_get_info", lambda device: {"cuda": (free, 80 * 2**30)}[device])
    assert portions(Multi3Net(device="cuda"), shape) == (512, 512 * patch)
    assert portions(Multi3Net(device="cuda", group=100, block_bytes=2**30), shape) == (100, 2**30)
    free = 4 * 2**30
    at_once, held = portions(Multi3Net(device="cuda"), shape)
    assert held == max(at_once * patch, Multi3Net.block_bytes)
    assert 0.7 * free < at_once * 10.4 * 2**30 / 512 < free
    free = 2**20
    assert portions(Multi3Net(device="cuda"), shape)[0] == 1
    assert portions(Multi3Net(device="cpu"), shape) == (32, Multi3Net.block_bytes)
    assert portions(Multi3Net(device="cpu", group=5), shape) == (5, Multi3Net.block_bytes)


@pytest.mark.slow
def test_labels_shuffled_by_clip_give_chance():
    pytest.importorskip("torch")
    windows, _, _, clip = library(n_clips=60, n_places=2)
    shuffled = np.random.default_rng(3).permutation(np.arange(60) % 3)[clip]
    activity = np.array(["bow", "run", "walk"])[shuffled]
    everywhere = np.ones(len(clip), bool)
    utility = utility_map(
        windows,
        CrossValidation(activity, clip, None, everywhere, ("bow", "run", "walk")),
        SMALL,
        resamples=20,
    )
    assert utility.mean.mean() == pytest.approx(1 / 3, abs=0.12)
    assert utility.classifier == "multi3net"


@WAYS
def test_what_is_tested_has_no_say_in_training(torch, settings):
    """Other windows in the tested fold leave the trained weights as they are."""
    from w2w_studies.classifiers.multi3net.network import Examples
    from w2w_studies.classifiers.multi3net.training import train

    network, examples, schedule, draws = parts(torch, [0, 1], settings)
    first = train(network, examples, schedule, draws)
    windows, labels, fold, _ = library()
    windows[fold == 0] = 1e3
    labels = np.where(fold == 0, 0, labels)
    learn, validation = split_windows(labels, fold, 0, settings.early_stopping)
    other = Examples.prepare(windows[:, [0, 1]], labels, learn, validation, "cpu", settings.spectrum)
    assert torch.equal(train(network, other, schedule, draws).best, first.best)


def test_checking_windows_are_whole_clips_of_another_fold_and_no_class_goes_untaught():
    rng = np.random.default_rng(0)
    clip = np.repeat(np.arange(40), 3)
    labels = rng.integers(6, size=40)[clip]
    fold = rng.integers(-1, 4, size=40)[clip]
    for tested in range(4):
        learn, validation = split_windows(labels, fold, tested)
        assert len(np.intersect1d(clip[learn], clip[validation])) == 0
        assert not np.isin(fold[np.concatenate([learn, validation])], tested).any()
        assert len(learn) + len(validation) == (fold != tested).sum()
        assert set(labels[learn]) == set(labels[fold != tested])
        assert (fold[validation] >= 0).all()
        everything, none = split_windows(labels, fold, tested, early_stopping=False)
        np.testing.assert_array_equal(everything, np.flatnonzero(fold != tested))
        assert len(none) == 0
    learn, validation = split_windows(np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1]), 0)
    assert learn.tolist() == [2, 3]
    assert validation.tolist() == []


@pytest.mark.slow
@WAYS
def test_training_goes_on_where_it_was_stopped(tmp_path, settings):
    pytest.importorskip("torch")
    from w2w_studies.classifiers.multi3net import group as multi3net_group

    windows, labels, fold, _ = library(n_places=3)
    work = (windows, labels, fold, np.ones(len(labels), bool))
    settings = replace(settings, group=2)
    undisturbed = settings.predict_folds(*work)

    class StopError(Exception):
        pass

    saves = []

    def stop_in_training(path, arrays, **options):
        saves.append(sorted(arrays))
        write_npz(path, arrays, **options)
        if len(saves) == 8:  # two groups done, a third in the middle
            raise StopError

    write_npz = multi3net_group.write_npz
    resumable = replace(settings, checkpoints=tmp_path / "work", checkpoint_epochs=5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(multi3net_group, "write_npz", stop_in_training)
        with pytest.raises(StopError):
            resumable.predict_folds(*work)
    assert saves[-1] != ["named"]
    steps = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            multi3net_group, "write_npz", lambda path, arrays: (steps.append(arrays), write_npz(path, arrays))
        )
        np.testing.assert_array_equal(resumable.predict_folds(*work), undisturbed)
    assert len([one for one in steps if "named" in one]) == 8 - 2
    finished = sorted((tmp_path / "work").iterdir())
    assert len(finished) == 8
    for path in finished[:2]:  # damaged files are made anew
        path.write_bytes(path.read_bytes()[:100])
    np.testing.assert_array_equal(resumable.predict_folds(*work), undisturbed)
    other = replace(resumable, seed=1).predict_folds(*work)
    assert (other != undisturbed).any()
    assert len(set((tmp_path / "work").iterdir()) & set(finished)) == 0


def cut_in_half(path, _):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def no_zip(path, _):
    path.write_bytes(b"nothing at all")


def with_shapes_of_another_network(path, arrays):
    np.savez(path, **{name: value[..., :1] if value.ndim else value for name, value in arrays.items()})


def without_one_array(path, arrays):
    np.savez(path, **{name: arrays[name] for name in sorted(arrays)[:-1]})


def with_numbers_of_another_kind(path, arrays):
    np.savez(path, **{name: value.astype(np.float16) for name, value in arrays.items()})


def with_a_pickle(path, arrays):
    np.savez(path, **{name: np.array({}, dtype=object) for name in arrays})


@pytest.fixture(scope="module", params=["finished", "in training"])
def checkpoint(request, tmp_path_factory):
    """A checkpoint's file and arrays, the settings and work that left it, and the outcome."""
    pytest.importorskip("torch")
    from w2w_studies.classifiers.multi3net import group as multi3net_group

    folder = tmp_path_factory.mktemp("work")
    windows, labels, fold, _ = library(n_places=1)
    work = (windows, labels, fold, fold == 0)
    settings = replace(STOPPING, epochs=3, checkpoints=folder, checkpoint_epochs=1)
    write_npz = multi3net_group.write_npz
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "in training":
            patch.setattr(
                multi3net_group,
                "write_npz",
                lambda path, arrays: None if "named" in arrays else write_npz(path, arrays),
            )
        outcome = settings.predict_folds(*work)
    (path,) = folder.iterdir()
    with np.load(path, allow_pickle=False) as saved:
        arrays = dict(saved)
    assert ("named" in arrays) == (request.param == "finished")
    return path, arrays, settings, work, outcome


@pytest.mark.parametrize(
    "damage",
    [
        cut_in_half,
        no_zip,
        with_shapes_of_another_network,
        without_one_array,
        with_numbers_of_another_kind,
        with_a_pickle,
    ],
)
def test_a_damaged_checkpoint_is_trained_again(checkpoint, damage):
    path, arrays, settings, work, outcome = checkpoint
    np.savez(path, **arrays)
    damage(path, arrays)
    np.testing.assert_array_equal(settings.predict_folds(*work), outcome)


@pytest.mark.slow
@pytest.mark.parametrize("changed", ["torch.__version__", "w2w_studies.classifiers.multi3net.group.PROGRAM"])
def test_what_another_version_left_is_not_taken_up(tmp_path, monkeypatch, changed):
    pytest.importorskip("torch")
    windows, labels, fold, _ = library(n_places=1)
    work = (windows, labels, fold, np.ones(len(labels), bool))
    settings = replace(SMALL, epochs=2, checkpoints=tmp_path)
    settings.predict_folds(*work)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    settings.predict_folds(*work)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before
    monkeypatch.setattr(changed, "0")
    settings.predict_folds(*work)
    assert not before.keys() & set(tmp_path.iterdir())
    assert len(list(tmp_path.iterdir())) == len(before)


def test_without_torch_it_says_how_to_get_it_and_nothing_else_needs_it():
    windows, labels, fold, _ = library()
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "torch", None)
        with pytest.raises(ValueError, match=r"needs PyTorch: get it with `pip install torch==2\.13\.0`"):
            SMALL.predict_folds(windows, labels, fold, np.ones(len(labels), bool))
    code = "import sys, w2w.core.study.config, w2w.headless.commands.run; assert 'torch' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_refuses_what_is_no_window_and_sizes_that_heads_do_not_divide():
    pytest.importorskip("torch")
    _, labels, fold, _ = library()
    with pytest.raises(ValueError, match=r"takes windows of shape \(W, N, samples, 6\), not \(48, 4, 9\)"):
        SMALL.predict_folds(np.zeros((48, 4, 9), np.float32), labels, fold, np.ones(48, bool))
    with pytest.raises(ValueError, match="width must be a multiple of 8"):
        Multi3Net(width=12)
    with pytest.raises(ValueError, match="patience must be at least 1"):
        Multi3Net(patience=0)
    with pytest.raises(ValueError, match="mixup must be at least 0"):
        Multi3Net(mixup=-0.1)
