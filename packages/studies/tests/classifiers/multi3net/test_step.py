# SPDX-License-Identifier: GPL-3.0-or-later
"""A step of training that a GPU can replay: against the plain one, padded, with nothing that would wait."""

from collections import Counter
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from w2w_studies.classifiers.multi3net.classifier import Multi3Net

SETTINGS = Multi3Net(width=8, hidden=16, embedding=8, batch_size=17, epochs=4)
WINDOWS, PATCHES, CLASSES = 40, 3, 3


def made(torch, settings=SETTINGS, dtype="float32", device="cpu"):
    """A step of untrained networks on noise, and the draws of two epochs, one by one."""
    from w2w_studies.classifiers.multi3net.network import Network
    from w2w_studies.classifiers.multi3net.step import Step, draw_epoch
    from w2w_studies.classifiers.multi3net.training import targets

    dtype, draws = getattr(torch, dtype), torch.Generator().manual_seed(0)
    network = Network(12, 6, CLASSES, settings.width, settings.hidden, settings.embedding)
    weights = network.initial(draws).to(dtype).repeat(PATCHES, 1)
    train = torch.arange(WINDOWS)[torch.arange(WINDOWS) % 5 > 0]
    labels = torch.randint(CLASSES, (len(train),), generator=draws)
    windows = torch.randn(PATCHES, 12, 6, WINDOWS, generator=draws).to(dtype)
    tensors = (
        windows.permute(3, 0, 1, 2).contiguous(), train,
        targets(labels, CLASSES, settings.label_smoothing).to(dtype),
        torch.tensor([[0.01], [0.02], [0.005]], dtype=dtype),
        weights, torch.zeros_like(weights), torch.zeros_like(weights),
    )  # fmt: skip
    drawn = [
        one
        for done in (0, settings.batches(len(train)))
        for one in draw_epoch(network, settings, len(train), done, draws, dtype)
    ]
    return Step(network, settings, *(values.to(device) for values in tensors)), drawn


def plain_step(torch, step, drawn, number):
    """A step as one would write it, with numbers of Python's; the loss of each patch before it."""
    from torch.nn import functional

    rows, others, share = drawn.rows, drawn.others, float(drawn.share)
    windows, target = step.windows.permute(1, 2, 3, 0)[..., step.train[rows]], step.target[:, rows]
    if step.settings.mixup:
        windows = torch.lerp(windows[..., others], windows, share)
        target = torch.lerp(target[:, others], target, share)
    weights = step.weights.clone().requires_grad_()
    scores = step.network.forward(weights, windows, [drawn.embedding, drawn.channels, drawn.segments])
    losses = -(functional.log_softmax(scores, dim=1) * target).sum(dim=1).mean(dim=1)
    (gradient,) = torch.autograd.grad(losses.sum(), weights)
    step.first_moment.lerp_(gradient, 1 - 0.9)
    step.second_moment.mul_(0.999).addcmul_(gradient, gradient, value=1 - 0.999)
    root = (step.second_moment / (1 - 0.999**number)).sqrt_().add_(1e-8)
    steps = step.settings.epochs * step.settings.batches(len(step.train))
    learning_rate = step.learning_rate * step.settings.schedule(number, steps)
    step.weights.mul_(1 - learning_rate * step.settings.weight_decay)
    step.weights.addcmul_(step.first_moment.div(root), learning_rate, value=-1 / (1 - 0.9**number))
    return losses.detach()


def outcome(torch, step, losses):
    """All that a step leaves."""
    return [torch.stack(losses), step.weights, step.first_moment, step.second_moment]


@pytest.mark.parametrize("changes", [{}, {"mixup": 0.0}, {"early_stopping": True}], ids=str)
def test_is_the_plain_step_to_the_bit(torch, changes):
    ours, drawn = made(torch, replace(SETTINGS, **changes))
    plain, _ = made(torch, replace(SETTINGS, **changes))
    expected = [plain_step(torch, plain, one, number) for number, one in enumerate(drawn, start=1)]
    for left, right in zip(
        outcome(torch, ours, [ours(one) for one in drawn]), outcome(torch, plain, expected), strict=True
    ):
        assert torch.equal(left, right)


@pytest.mark.parametrize("size", [16, 24])
def test_windows_that_fill_a_batch_count_nothing(torch, size):
    """Batches of 16 windows, and filled up to 24, in double precision."""
    from w2w_studies.classifiers.multi3net.step import Drawn, together

    alone, drawn = made(torch, dtype="float64")
    filled, _ = made(torch, dtype="float64")
    assert {len(one.rows) for one in drawn} == {16}
    at_once = together(drawn, size)
    assert at_once.rows.shape == (len(drawn), size)
    losses = [filled(one) for one in map(Drawn._make, zip(*at_once, strict=True))]
    for left, right in zip(
        outcome(torch, filled, losses), outcome(torch, alone, [alone(one) for one in drawn]), strict=True
    ):
        torch.testing.assert_close(left, right, rtol=1e-9, atol=1e-11)


def test_draws_sent_at_once_are_those_drawn_one_by_one(torch):
    from w2w_studies.classifiers.multi3net.step import OF_WINDOWS, Drawn, together

    _, drawn = made(torch, replace(SETTINGS, batch_size=13))
    sizes = [len(one.rows) for one in drawn]
    assert sizes == [16, 16, 16, 16] or len(set(sizes)) > 1
    for one, sent in zip(drawn, map(Drawn._make, zip(*together(drawn, 20), strict=True)), strict=True):
        n_windows = len(one.rows)
        for name, kept in one._asdict().items():
            given = getattr(sent, name)
            if name == "counts":
                given = given * n_windows / 20
            if name in Drawn._fields[:OF_WINDOWS]:
                assert not given[..., n_windows:].any()
                given = given[..., :n_windows]
            torch.testing.assert_close(given, kept, rtol=1e-6, atol=0)


@pytest.mark.later
def test_no_operation_waits_for_numbers_or_makes_them_on_the_cpu(torch):
    """On the device that holds no numbers: to look at one fails, and what lies elsewhere is told."""
    from torch.utils._python_dispatch import TorchDispatchMode
    from torch.utils._pytree import tree_leaves

    from w2w_studies.classifiers.multi3net.step import Drawn

    class AllThere(TorchDispatchMode):
        seen = 0

        def __torch_dispatch__(self, function, types, args=(), kwargs=None):
            given = function(*args, **(kwargs or {}))
            self.seen += 1
            for value in tree_leaves((args, kwargs, given)):
                assert not isinstance(value, torch.Tensor) or value.device.type == "meta", function
            return given

    step, drawn = made(torch, device="meta")
    drawn = Drawn(*(values.to("meta") for values in drawn[0]))
    with AllThere() as watched:
        assert step(drawn).shape == (PATCHES,)
    assert watched.seen > 100
    for spoilt in (
        lambda: drawn.rows.to("cpu"),
        lambda: float(drawn.share),
        lambda: step.train[step.train > 0],
        lambda: torch.arange(3),
    ):
        with pytest.raises((AssertionError, RuntimeError, NotImplementedError)), AllThere():
            spoilt()


class Stream:
    """The CPU does one thing after another."""

    def wait_stream(self, other):
        assert isinstance(other, Stream)


class Tape:
    """How a CUDA graph behaves: what is recorded has no effect; a replay does it on the same memory."""

    def __init__(self):
        self.operations = []

    @classmethod
    def of(cls, step):
        """A step that is replayed from a tape."""
        from w2w_studies.classifiers.multi3net.step import Replayed

        return Replayed(step, graph=cls(), side=Stream())

    def replay(self):
        import torch

        with torch._C._AutoDispatchBelowADInplaceOrView():
            for function, args, kwargs, given in self.operations:
                now = function(*args, **kwargs)
                if now is not given:
                    given.copy_(now)


@pytest.fixture
def taped(torch, monkeypatch):
    """Let tapes stand in for CUDA graphs; gives the tapes."""
    from torch.utils._python_dispatch import TorchDispatchMode

    tapes = []

    class Recording(TorchDispatchMode):
        def __init__(self, tape, stream):
            super().__init__()
            assert isinstance(stream, Stream)
            self.tape, self.before = tape, []
            tapes.append(tape)

        def __torch_dispatch__(self, function, types, args=(), kwargs=None):
            schema = function._schema
            if schema.is_mutable:
                self.before.append((args[0], args[0].clone()))
            given = function(*args, **(kwargs or {}))
            outputs = given if isinstance(given, (list, tuple)) else [given]
            views = any(
                output.untyped_storage().data_ptr() == value.untyped_storage().data_ptr()
                for output in outputs
                for value in args
                if isinstance(value, torch.Tensor)
            )
            if schema.is_mutable or not views:
                assert isinstance(given, torch.Tensor), function
                self.tape.operations.append((function, args, kwargs or {}, given))
            return given

        def __exit__(self, *raised):
            super().__exit__(*raised)
            for tensor, value in reversed(self.before):
                tensor.copy_(value)

    monkeypatch.setattr(torch.cuda, "current_stream", Stream)
    monkeypatch.setattr(torch.cuda, "stream", nullcontext)
    monkeypatch.setattr(torch.cuda, "graph", Recording)
    return tapes


def test_a_replay_is_the_step_again_with_what_was_drawn_for_it(torch, taped):
    from w2w_studies.classifiers.multi3net.step import PLAIN_STEPS

    ours, drawn = made(torch)
    plain, _ = made(torch)
    replayed = Tape.of(ours)
    drawn = drawn * 2
    losses = [replayed(one) for one in drawn]
    assert len(drawn) > PLAIN_STEPS + 2
    assert len(taped) == 1
    assert len(taped[0].operations) > 100
    for left, right in zip(
        outcome(torch, ours, losses), outcome(torch, plain, [plain(one) for one in drawn]), strict=True
    ):
        assert torch.equal(left, right)


@pytest.mark.later
@pytest.mark.parametrize("stopping", [{}, {"early_stopping": True, "lr_patience": 1, "patience": 3}], ids=str)
def test_training_by_replays_is_training(torch, taped, monkeypatch, stopping):
    """Whole trainings in double precision, batches filled up, with rates that fall and patches that leave."""
    from w2w_studies.classifiers.multi3net import training
    from w2w_studies.classifiers.multi3net.network import Examples
    from w2w_studies.classifiers.multi3net.step import Drawn, together

    settings = replace(SETTINGS, epochs=12, **stopping)
    step, _ = made(torch, settings, "float64")
    labels = torch.randint(CLASSES, (WINDOWS,), generator=torch.Generator().manual_seed(1))
    examples = Examples(step.windows, labels, step.train, torch.arange(0, WINDOWS, 5))
    work = (step.network, examples, settings, lambda epoch: torch.Generator().manual_seed(epoch))
    expected = training.train(*work)
    one_step = training._step
    monkeypatch.setattr(training, "_step", lambda *given: Tape.of(one_step(*given)))
    padded = []

    def beside(drawn, windows, size):
        padded.append((windows.shape, size))
        return map(Drawn._make, zip(*together(drawn, size), strict=True))

    monkeypatch.setattr(training, "beside", beside)
    found = training.train(*work, size=24)
    torch.testing.assert_close(found.best, expected.best, rtol=1e-6, atol=1e-8)
    assert found.epochs.tolist() == expected.epochs.tolist()
    assert found.step == expected.step
    epochs = Counter(shape for shape, _ in padded)  # of two steps; the fourth is captured
    assert len(taped) == sum(count > 1 for count in epochs.values())
    assert (len(taped) > 1) == bool(stopping)


def test_a_rate_that_was_reduced_is_the_one_that_the_next_steps_take(torch):
    from w2w_studies.classifiers.multi3net import training
    from w2w_studies.classifiers.multi3net.network import Examples

    rates = {"early_stopping": True, "lr_patience": 1, "patience": 9, "lr_factor": 1e-9}
    step, _ = made(torch, replace(SETTINGS, epochs=8, **rates))
    labels = torch.randint(CLASSES, (WINDOWS,), generator=torch.Generator().manual_seed(1))
    examples = Examples(step.windows, labels, step.train, torch.arange(0, WINDOWS, 5))
    kept = []
    training.train(
        step.network,
        examples,
        step.settings,
        lambda epoch: torch.Generator().manual_seed(epoch),
        after_epoch=lambda state: kept.append((state.learning_rate[:, 0].clone(), state.weights.clone())),
    )
    rates = torch.stack([rate for rate, _ in kept])[:-1]
    moved = torch.stack([weights for _, weights in kept]).diff(dim=0).abs().amax(dim=2)
    assert (moved[rates < 1e-6] < 1e-6).all()
    assert (moved[rates > 1e-6] > 1e-4).all()
    assert {True, False} == set((rates < 1e-6).flatten().tolist())


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # PyTorch's own
def test_is_compiled_whole_but_for_the_gradient_and_is_the_same(torch):
    """By torch.compile without its last step, which needs a compiler."""
    ours, drawn = made(torch, dtype="float64")
    plain, _ = made(torch, dtype="float64")
    compiled = torch.compile(ours, dynamic=False, backend="aot_eager")
    for left, right in zip(
        outcome(torch, ours, [compiled(one) for one in drawn]),
        outcome(torch, plain, [plain(one) for one in drawn]),
        strict=True,
    ):
        torch.testing.assert_close(left, right, rtol=1e-9, atol=1e-11)


def test_a_gpu_replays_what_it_would_do_step_by_step(capsys):
    from benchmarks.multi3net_gpu import both_ways, no_gpu

    if why := no_gpu():
        pytest.skip(why)
    graph, eager = both_ways(patches=8, windows=320, epochs=20)
    with capsys.disabled():
        print(f"a replayed graph {graph.seconds:.2f} s, launched one by one {eager.seconds:.2f} s")
    assert (graph.named == eager.named).mean() >= 0.95
    assert abs(graph.accuracy - eager.accuracy) <= 0.02
    assert len(np.unique(graph.named)) > 1
