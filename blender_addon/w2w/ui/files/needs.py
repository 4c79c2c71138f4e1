# SPDX-License-Identifier: GPL-3.0-or-later
"""How cheap the recommended sensors may be: what `w2w need` does, on the cards of the panel."""

from typing import Any

import bpy

from ...core.findings.advice_content import need_content, with_needs
from ...core.study.choosing import find_needs
from ...core.study.results import StudyResults
from ..jobs.jobs import Steps, on_body
from ..study import lists, operators
from .save_results import with_saved


def missing_for_needs(body: bpy.types.Object) -> str:
    """What prevents finding needs, as a sentence, or ""."""
    return "" if lists.advice_of(body.w2w) else "Choose sensors first (step 6)"


@on_body
def need_steps(mesh: bpy.types.Object) -> Steps:
    """Find what the study's sensors need, and keep it with their cards."""

    def find(study: StudyResults) -> list[dict[str, Any]]:
        return [need_content(one) for one in find_needs(study)]

    found = yield from with_saved(mesh, find, "trying cheaper sensors")
    content = lists.advice_of(mesh.w2w) or {}
    lists.keep_advice(mesh.w2w, content | {"cards": with_needs(content.get("cards", ()), found)})
    return ". ".join(f"{need['place']}: {need['sentence'] or 'these clips tell nothing'}" for need in found)


class W2W_OT_find_needs(operators.JobOperator, bpy.types.Operator):
    """Find how slow, coarse, noisy and short in range each recommended sensor may be"""

    missing = staticmethod(lambda _context, body: missing_for_needs(body))
    steps = staticmethod(need_steps)
