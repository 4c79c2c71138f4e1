# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study read back."""

from pathlib import Path
from types import SimpleNamespace

from w2w.core.study import results
from w2w.core.study.results import StudyResults


class Recording:
    """A recording during whose measuring another thread reads another clip."""

    def __init__(self, held: dict) -> None:
        self.acc = self.gyr = self
        self._held = held

    @property
    def nbytes(self) -> int:
        """Bytes, as another clip arrives."""
        self._held[object()] = self
        return 1

    def at(self, _patches: object) -> "Recording":
        """The recording itself."""
        return self


def test_a_clip_is_read_while_another_thread_keeps_its_own(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "one").touch()
    monkeypatch.setattr(results, "signals_file", lambda folder, clip: folder / clip)
    study = SimpleNamespace(places=[(tmp_path, "one")], _held={})
    study._held[1] = Recording(study._held)
    monkeypatch.setattr(results, "ImuRecording", SimpleNamespace(load=lambda _: Recording(study._held)))
    assert StudyResults.recording(study, 0, [0]) is study._held[0]
