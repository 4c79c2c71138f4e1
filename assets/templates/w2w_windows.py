"""The windows of this folder for PyTorch; needs numpy and torch, not W2W.

    from w2w_windows import Windows
    loader = torch.utils.data.DataLoader(Windows(".", train=True), batch_size=64, shuffle=True)

Windows of one clip overlap and are alike: split by `clips`, never by window. `train=True` gives all windows
of the clips, `train=False` only those that do not overlap one another, to test on.
"""

import json
from pathlib import Path

import numpy as np
import torch


class Windows(torch.utils.data.Dataset):
    """Pairs of a window (channels, time), float32, and its activity's number in `classes`."""

    def __init__(self, folder, clips=None, train=True):
        folder = Path(folder)
        self.x = np.load(folder / "X.npy", mmap_mode="r")
        facts = json.loads((folder / "facts.json").read_text(encoding="utf-8"))
        self.classes, self.channels, self.rate = facts["classes"], facts["channels"], facts["rate_hz"]
        labels, clip = np.load(folder / "y.npy"), np.load(folder / "clip.npy")
        number = {name: k for k, name in enumerate(self.classes)}
        wanted = np.ones(len(labels), bool) if clips is None else np.isin(clip, list(clips))
        if not train:
            wanted &= np.load(folder / "is_test.npy")
        self.rows = np.flatnonzero(wanted)
        self.y = np.array([number[name] for name in labels])[self.rows]
        self.clips = clip[self.rows]
        self.subjects = np.load(folder / "subject.npy")[self.rows]

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        window = torch.from_numpy(np.array(self.x[self.rows[index]]))
        return window, int(self.y[index])
