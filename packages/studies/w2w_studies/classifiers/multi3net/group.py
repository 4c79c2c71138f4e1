# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of `Multi3Net` that is trained and saved in one piece: some patches and one fold."""

import hashlib
import math
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path

import numpy as np
import torch

from w2w.core.files import load_arrays, write_npz
from w2w.core.windows.inputs import ITEM_BYTES

from .network import Examples, Network
from .settings import Settings
from .training import State, name_windows, train

PROGRAM = 3
"""Number of the network and of its training; checkpoints of another one are not resumed."""


ON_A_CPU = 32
"""Patches trained together on a CPU."""
GPU_SHARE, GPU_COPIES, GPU_NETWORK = 0.9, 6.1, 4 * 2**20
"""Of a GPU's free memory, what is used; a patch's copies of its windows at most, and bytes of its network."""


def device_of(settings: Settings) -> str:
    """The device asked for, or a GPU where there is one."""
    return settings.device or ("cuda" if torch.cuda.is_available() else "cpu")


def portions(settings: Settings, shape: tuple[int, ...]) -> tuple[int, int]:
    """Patches to train together on windows of a shape (W, N, samples, channels), and bytes to hold of these.

    As asked, or on a GPU as many patches as fit.
    """
    if device_of(settings) == "cpu":
        return settings.group or ON_A_CPU, settings.block_bytes
    windows = shape[0] * math.prod(shape[2:]) * ITEM_BYTES
    free, _ = torch.cuda.mem_get_info(device_of(settings))
    fit = max(1, int(GPU_SHARE * free / (GPU_COPIES * windows + GPU_NETWORK)))
    at_once = min(shape[1], settings.group or fit)
    return at_once, max(settings.block_bytes, at_once * windows)


@dataclass(frozen=True, eq=False)
class Group:
    """Some patches and one fold: trained together, saved together."""

    settings: Settings
    windows: np.ndarray  # (W, P, samples, channels)
    labels: np.ndarray  # (W,), int
    train: np.ndarray  # int: indices of windows
    validation: np.ndarray
    test: np.ndarray
    fold: int
    size: int  # windows of a batch on a GPU: the same for all folds

    @cached_property
    def file(self) -> Path | None:
        """The checkpoint, or None if none are kept."""
        folder = self.settings.checkpoints
        return None if folder is None else folder / f"{self._key()}.npz"

    def predict(self) -> np.ndarray:
        """Classes (tested windows, patches), by networks trained now or resumed from a checkpoint."""
        saved = self._saved("named").get("named")
        if saved is not None and self._is_outcome(saved):
            return saved
        settings = self.settings
        device = device_of(settings)
        given = (self.windows, self.labels, self.train, self.validation)
        examples = Examples.prepare(*given, device, settings.spectrum)
        sizes = (settings.width, settings.hidden, settings.embedding)
        network = Network(*examples.windows.shape[2:], int(self.labels.max()) + 1, *sizes)
        saved = self._saved(*(field.name for field in fields(State)))
        state = State.restore(saved, device, self.windows.shape[1], network.n_weights) if saved else None
        state = train(network, examples, settings, self._generator, state, self._save_state, self.size)
        tested = examples.windows[torch.as_tensor(self.test, device=device)]
        named = name_windows(network, state.best, tested).T.cpu().numpy().astype(np.int16)
        if self.file is not None:
            write_npz(self.file, {"named": named})
        return named

    def _generator(self, epoch: int) -> torch.Generator:
        """Draws of an epoch, on the CPU so that a GPU meets the same."""
        seed = np.random.SeedSequence([self.settings.seed, self.fold, epoch]).generate_state(1, np.uint64)[0]
        return torch.Generator().manual_seed(int(seed >> np.uint64(1)))

    def _save_state(self, state: State) -> None:
        if self.file is not None and state.epoch % self.settings.checkpoint_epochs == 0:
            write_npz(self.file, state.arrays())

    def _saved(self, *names: str) -> dict[str, np.ndarray]:
        """These arrays, as an earlier run left them of just this work; none if one is missing or damaged."""
        if self.file is None or not self.file.exists():
            return {}
        try:
            return load_arrays(self.file, names, "is no checkpoint")
        except (OSError, ValueError):
            return {}

    def _is_outcome(self, named: np.ndarray) -> bool:
        """Whether these are classes of the tested windows at these patches."""
        if named.dtype != np.int16 or named.shape != (len(self.test), self.windows.shape[1]):
            return False
        return not named.size or (named.min() >= 0 and named.max() <= self.labels.max())

    def _key(self) -> str:
        """Hash of all that decides the outcome: signals, labels, splits, settings and the program."""
        settings = self.settings
        free = ("group", "device", "replayed", "compiled", "block_bytes", "checkpoints", "checkpoint_epochs")
        chosen = {name: value for name, value in vars(settings).items() if name not in free}
        facts = (PROGRAM, str(torch.__version__), sorted(chosen.items()), self.fold, self.windows.shape)
        digest = hashlib.sha256(repr(facts).encode())
        for rows in (self.labels, self.train, self.validation, self.test):
            digest.update(np.ascontiguousarray(rows, dtype=np.int64).tobytes())
        digest.update(np.ascontiguousarray(self.windows, dtype=np.float32).tobytes())
        return digest.hexdigest()[:32]
