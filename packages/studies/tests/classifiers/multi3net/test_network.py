# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of Multi3Net against PyTorch's own: network, attention, loss; its inputs, its learning rate."""

from dataclasses import replace

import numpy as np
import pytest

from w2w_studies.classifiers.multi3net.classifier import Multi3Net

CHANNELS = 6


def test_equals_torchs_own_modules(torch):
    """The hand-written program against torch.nn's layers with the same weights, and its slopes."""
    from w2w_studies.classifiers.multi3net.network import HEADS, SEGMENTS, Network

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
    from w2w_studies.classifiers.multi3net.network import attention_among_few

    draws = torch.Generator().manual_seed(1)
    tokens = [torch.randn(2, 3, 4, 5, 2, generator=draws, dtype=torch.float64) for _ in range(3)]
    dropout = torch.rand(3, 5, 5, 2, generator=draws, dtype=torch.float64)
    query, key, value = (part.requires_grad_() for part in tokens)
    heads_first = [part.permute(0, 4, 1, 3, 2) for part in tokens]  # (P, B, heads, T, E)
    expected = torch.nn.functional.scaled_dot_product_attention(*heads_first).permute(0, 2, 4, 3, 1)
    torch.testing.assert_close(attention_among_few(query, key, value), expected)
    torch.autograd.gradcheck(attention_among_few, (query, key, value, dropout))


def test_the_spectrum_tells_tempo_and_direction_whenever_a_window_begins(torch):
    from w2w_studies.classifiers.multi3net.network import shape_of

    time = torch.arange(50)[:, None] / 50
    swings = ((4, 0.0), (4, 0.3), (9, 0.0))
    waves = [torch.sin(2 * torch.pi * (tempo * time + start)) + 5 for tempo, start in swings]
    signals = torch.stack(waves, dim=-1)[None]  # (1, samples, 1 channel, 3 windows)
    told = shape_of(signals, torch.ones(1, 1, 1, 1), 12)[0, :, 0]
    assert told.shape == (14, 3)
    torch.testing.assert_close(told[0], torch.full((3,), 5.0))
    torch.testing.assert_close(told[:, 0], told[:, 1], rtol=0, atol=0.02)
    assert told[2:].argmax(dim=0).tolist() == [4 - 1, 4 - 1, 9 - 1]


def test_loss_is_torchs_own_of_balanced_classes_and_smoothed_labels(torch):
    from w2w_studies.classifiers.multi3net.training import mean_loss, targets

    draws = torch.Generator().manual_seed(0)
    labels = torch.tensor([0, 0, 0, 1, 2, 2])
    scores = torch.randn(2, 3, 6, generator=draws)
    each = torch.nn.functional.cross_entropy(
        scores, labels.expand(2, -1), reduction="none", label_smoothing=0.2
    )
    by_class = torch.stack([each[:, labels == one].mean(dim=1) for one in range(3)])
    torch.testing.assert_close(mean_loss(scores, targets(labels, 3, 0.2)), by_class.mean(dim=0))


def test_the_rate_rises_and_falls_to_nothing_or_keeps_until_it_drops():
    settings = Multi3Net()
    paces = [settings.schedule(step, 200) for step in range(1, 201)]
    assert np.argmax(paces) in range(15, 25)
    assert paces[0] < 0.1
    assert paces[-1] == pytest.approx(0, abs=1e-6)
    assert replace(settings, early_stopping=True).schedule(150, 200) == 1
