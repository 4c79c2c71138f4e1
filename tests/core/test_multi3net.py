# SPDX-License-Identifier: GPL-3.0-or-later
"""Multi3Net's IMU branch: together as alone, stopped apart, taken up again, never shown the tested fold."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from blender_addon.w2w.core.classifiers import multi3net
from blender_addon.w2w.core.classifiers.multi3net import Multi3Net, rows_to_learn
from blender_addon.w2w.core.utility import utility_map

CHANNELS = 6
SMALL = Multi3Net(width=8, hidden=16, embedding=8, batch=16, epochs=12, patience=12, rate=0.005)


@pytest.fixture
def torch():
    torch = pytest.importorskip("torch")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield torch
    torch.set_num_threads(threads)


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
    from blender_addon.w2w.core.classifiers.multi3net_network import Network
    from blender_addon.w2w.core.classifiers.multi3net_training import Examples, Schedule

    windows, labels, fold, _ = library()
    windows = windows[:, places].astype(dtype or np.float32)
    learn, check = rows_to_learn(labels, fold, 0)
    network = Network(windows.shape[2], 6, 3, settings.width, settings.hidden, settings.embedding)
    schedule = Schedule(
        settings.rate,
        settings.batch,
        settings.epochs,
        settings.patience,
        settings.plateau,
        settings.drop,
    )
    return network, Examples.prepare(windows, labels, learn, check, "cpu"), schedule, generator(torch)


def generator(torch):
    return lambda epoch: torch.Generator().manual_seed(100 + epoch)


def test_learns_what_it_can_and_finds_noise_harder():
    pytest.importorskip("torch")
    windows, labels, fold, _ = library()
    named = replace(SMALL, epochs=15).predict_folds(windows, labels, fold, np.ones(len(labels), bool))
    right = (named == labels[:, None]).mean(axis=0)
    assert right[0] > 0.9
    assert right[3] < right[0] - 0.2


@pytest.mark.parametrize("patience", [12, 2])
def test_a_place_among_others_is_trained_as_alone(torch, patience):
    """In double precision, dropout on, whether or not others stop before it."""
    from blender_addon.w2w.core.classifiers.multi3net_training import train

    settings = replace(SMALL, patience=patience, plateau=1)
    network, examples, schedule, draws = parts(torch, [0, 1, 2, 3], settings, np.float64)
    together = train(network, examples, schedule, draws)
    if patience == 2:
        assert len(set(together.epochs.tolist())) > 1
    for place in range(4):
        network, examples, schedule, draws = parts(torch, [place], settings, np.float64)
        alone = train(network, examples, schedule, draws)
        torch.testing.assert_close(alone.best[0], together.best[place], rtol=1e-9, atol=1e-11)
        assert alone.epochs[0] == together.epochs[place]


def test_single_precision_is_the_same_within_rounding(torch):
    from blender_addon.w2w.core.classifiers.multi3net_training import train

    settings = replace(SMALL, epochs=5)
    together = train(*parts(torch, [0, 1, 2, 3], settings))
    alone = train(*parts(torch, [2], settings))
    torch.testing.assert_close(alone.weights[0], together.weights[2], rtol=1e-3, atol=1e-5)


def test_equals_torchs_own_modules(torch):
    """The hand-written program against torch.nn's layers with the same weights, and its slopes."""
    from blender_addon.w2w.core.classifiers.multi3net_network import HEADS, SEGMENTS, Network

    network = Network(samples=20, channels=CHANNELS, classes=3, width=16, hidden=24, embedding=64)
    draws = torch.Generator().manual_seed(0)
    weights = torch.stack([network.initial(draws) for _ in range(2)]).double().requires_grad_()
    windows = torch.randn(2, 20, CHANNELS, 5, generator=draws).double()
    scores = network.forward(weights, windows)

    def module(w):
        """One place's network of torch's modules."""
        get = {name: part.reshape(part.shape[1:]) for name, part in network._named(w[None]).items()}

        def vector(name):
            return get[name].reshape(-1)

        def attend(tokens, name):
            layer = torch.nn.MultiheadAttention(tokens.shape[-1], HEADS, batch_first=True).double()
            own = {
                "in_proj_weight": get[f"{name}_qkv"],
                "in_proj_bias": vector(f"{name}_qkv_bias"),
                "out_proj.weight": get[f"{name}_out"],
                "out_proj.bias": vector(f"{name}_out_bias"),
            }
            return torch.func.functional_call(layer, own, (tokens, tokens, tokens))[0]

        def norm(tokens, name):
            return torch.nn.functional.layer_norm(
                tokens, tokens.shape[-1:], vector(f"{name}_scale"), vector(f"{name}_shift")
            )

        def linear(x, name):
            return torch.nn.functional.linear(x, get[name], vector(f"{name}_bias"))

        def run(x):  # (B, 6, samples)
            position = torch.arange(CHANNELS)[:, None] / 10000 ** (torch.arange(0, 16, 2) / 16)
            encoding = torch.stack([position.sin(), position.cos()], -1).reshape(CHANNELS, 16)
            tokens = linear(x, "embed") + encoding
            tokens = norm(tokens + attend(tokens, "channels"), "channels")
            hidden = linear(tokens.transpose(1, 2).flatten(1), "hidden").relu()
            segments = linear(hidden, "describe").view(len(x), -1, SEGMENTS)  # (B, numbers, segments)
            kernel = get["convolve"].view(-1, 3, segments.shape[1]).transpose(1, 2)
            segments = torch.nn.functional.conv1d(segments, kernel, vector("convolve_bias"), padding=1)
            segments = norm(segments.transpose(1, 2), "head")
            segments = segments + attend(segments, "head")
            return linear(linear(segments.transpose(1, 2).flatten(1), "mix").relu(), "name")

        return run

    expected = torch.stack([module(w)(x.permute(2, 1, 0)).T for w, x in zip(weights, windows, strict=True)])
    torch.testing.assert_close(scores, expected, rtol=1e-5, atol=1e-6)
    slopes = [torch.autograd.grad(out.square().sum(), weights)[0] for out in (scores, expected)]
    torch.testing.assert_close(*slopes, rtol=1e-4, atol=1e-6)


def test_attention_among_few_is_attention_and_has_its_slopes(torch):
    from blender_addon.w2w.core.classifiers.multi3net_attention import attention_among_few

    draws = torch.Generator().manual_seed(1)
    tokens = [torch.randn(2, 3, 4, 5, 2, generator=draws, dtype=torch.float64) for _ in range(3)]
    dropout = torch.rand(3, 5, 5, 2, generator=draws, dtype=torch.float64)
    query, key, value = (part.requires_grad_() for part in tokens)
    heads_first = [part.permute(0, 4, 1, 3, 2) for part in tokens]  # (P, B, heads, T, E)
    expected = torch.nn.functional.scaled_dot_product_attention(*heads_first).permute(0, 2, 4, 3, 1)
    torch.testing.assert_close(attention_among_few(query, key, value), expected)
    torch.autograd.gradcheck(attention_among_few, (query, key, value, dropout))


def test_group_size_changes_nothing_but_rounding():
    pytest.importorskip("torch")
    windows, labels, fold, _ = library()
    is_test = np.ones(len(labels), bool)
    named = [
        replace(SMALL, group=group, epochs=6).predict_folds(windows, labels, fold, is_test)
        for group in (1, 3, 4)
    ]
    assert (named[0] == named[2]).mean() > 0.98
    assert (named[1] == named[2]).mean() > 0.98


def test_labels_shuffled_by_clip_give_chance():
    pytest.importorskip("torch")
    windows, _, _, clip = library(n_clips=60, n_places=2)
    shuffled = np.random.default_rng(3).permutation(np.arange(60) % 3)[clip]
    activity = np.array(["bow", "run", "walk"])[shuffled]
    everywhere = np.ones(len(clip), bool)
    utility = utility_map(
        windows, activity, clip, None, everywhere, ("bow", "run", "walk"), classifier=SMALL, resamples=20
    )
    assert utility.mean.mean() == pytest.approx(1 / 3, abs=0.12)
    assert utility.classifier == "multi3net"


def test_what_is_tested_has_no_say_in_training(torch):
    """Other windows in the tested fold leave the trained weights as they are."""
    from blender_addon.w2w.core.classifiers.multi3net_training import Examples, train

    network, examples, schedule, draws = parts(torch, [0, 1])
    first = train(network, examples, schedule, draws)
    windows, labels, fold, _ = library()
    windows[fold == 0] = 1e3
    labels = np.where(fold == 0, 0, labels)
    learn, check = rows_to_learn(labels, fold, 0)
    other = Examples.prepare(windows[:, [0, 1]], labels, learn, check, "cpu")
    assert torch.equal(train(network, other, schedule, draws).best, first.best)


def test_checking_windows_are_whole_clips_of_another_fold_and_no_class_goes_untaught():
    rng = np.random.default_rng(0)
    clip = np.repeat(np.arange(40), 3)
    labels = rng.integers(6, size=40)[clip]
    fold = rng.integers(-1, 4, size=40)[clip]
    for tested in range(4):
        learn, check = rows_to_learn(labels, fold, tested)
        assert len(np.intersect1d(clip[learn], clip[check])) == 0
        assert not np.isin(fold[np.concatenate([learn, check])], tested).any()
        assert len(learn) + len(check) == (fold != tested).sum()
        assert set(labels[learn]) == set(labels[fold != tested])
        assert (fold[check] >= 0).all()
    learn, check = rows_to_learn(np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1]), 0)
    assert learn.tolist() == [2, 3]
    assert check.tolist() == []


def test_training_goes_on_where_it_was_stopped(tmp_path):
    pytest.importorskip("torch")
    windows, labels, fold, _ = library(n_places=3)
    work = (windows, labels, fold, np.ones(len(labels), bool))
    settings = replace(SMALL, group=2)
    undisturbed = settings.predict_folds(*work)

    class StopError(Exception):
        pass

    saves = []

    def stop_in_training(path, arrays, **options):
        saves.append(sorted(arrays))
        write_npz(path, arrays, **options)
        if len(saves) == 8:  # two groups done, a third in the middle
            raise StopError

    write_npz = multi3net.write_npz
    resumable = replace(settings, checkpoints=tmp_path / "work", checkpoint_epochs=5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(multi3net, "write_npz", stop_in_training)
        with pytest.raises(StopError):
            resumable.predict_folds(*work)
    assert saves[-1] != ["named"]
    steps = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            multi3net, "write_npz", lambda path, arrays: (steps.append(arrays), write_npz(path, arrays))
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


@pytest.mark.parametrize("changed", ["torch.__version__", f"{multi3net.__name__}.PROGRAM"])
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
    code = "import sys, blender_addon.w2w.core.study, headless.run; assert 'torch' not in sys.modules"
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
