# SPDX-License-Identifier: GPL-3.0-or-later
"""The garments of a run: read from the command line, and fitted to the body before the first clip."""

from pathlib import Path

from ...core.body.body import Body
from ...core.files import file_sha256
from ...core.garments.cut import BLEND, KINDS, cut, split_name
from ...core.given import inside
from ...core.imu.cover import FITTED, Cover, cover, save_covers, without_overlap
from ...core.patches.patches import PatchSet
from ...core.reading.guard import guarded, quiet_output
from ...core.study.clip_files import mark_changing
from ...core.study.config import StudyConfig
from ..blender import needs_blender
from .folder import save_new
from .workers import run_alone


def parse_garments(text: str) -> tuple[str, ...]:
    """Garments from a comma-separated list; a ValueError says which is unknown, or has no file."""
    garments = tuple(part.strip() for part in text.split(",") if part.strip())
    for number, garment in enumerate(garments):
        if garment in garments[:number]:
            raise ValueError(f"--garment: '{garment}' is given twice")
        file, name = split_name(garment)
        if file and not Path(file).is_file():
            raise ValueError(f"--garment: there is no file {file}")
        if not name or (not file and name.lower().endswith(BLEND)):
            raise ValueError(f"--garment: say which object of {file or name} is worn: {file or name}:OBJECT")
        if not file and name not in KINDS:
            raise ValueError(
                f"--garment: there is no garment called '{name}': write {', '.join(KINDS)} or "
                "FILE.blend:OBJECT"
            )
    return garments


def files_worn(config: StudyConfig) -> list[Path | None]:
    """The file of each garment; None of W2W's own."""
    return [Path(file) if (file := split_name(garment)[0]) else None for garment in config.garments]


def fit_covers(config: StudyConfig, body: Body, patches: PatchSet, out: Path) -> None:
    """Find the patches that the study's garments cover, and write them down for the work on clips.

    A ValueError says which garment cannot be worn, or covers nothing that an outer one leaves.
    """
    path = inside(out, FITTED)
    if not config.garments:
        if path.exists():
            mark_changing(out)
            path.unlink()
        return
    hashes = [file_sha256(file) if file else "" for file in files_worn(config)]
    found = without_overlap([_cover(garment, body, patches) for garment in config.garments])
    for garment, own in zip(config.garments, found, strict=True):
        if not len(own):
            raise ValueError(f"'{garment}' covers no patch that another garment leaves: leave one out")
    covers = dict(zip(config.garments, found, strict=True))
    save_new(lambda path: save_covers(path, covers, hashes), out, FITTED)


def _cover(garment: str, body: Body, patches: PatchSet) -> Cover:
    file, name = split_name(garment)
    if not file:
        cloth = cut(name, body).cloth
        return cover(cloth.vertices, cloth.faces, body, patches)
    found = run_alone(_cover_in_blender, garment, body, patches)
    if found is None:
        raise ValueError(f"--garment: Blender crashed on {file}: it is damaged")
    if isinstance(found, str):
        raise ValueError(f"--garment: {found}")
    return found


def _cover_in_blender(garment: str, body: Body, patches: PatchSet) -> Cover | str:
    """The cover, or a sentence."""
    with guarded():
        try:
            with needs_blender(), quiet_output():
                from ...scene.cloth.bake import fitted

                return fitted(garment, body, patches)
        except ValueError as error:
            return str(error)
