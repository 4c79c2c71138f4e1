# SPDX-License-Identifier: GPL-3.0-or-later
"""The public names by the modules that they come from; `__init__.py` imports each when it is first used."""

from .api.examples import example_motions as example_motions
from .api.loading import (
    from_joints as from_joints,
    from_smpl as from_smpl,
    load as load,
    load_body as load_body,
)
from .api.rank import rank as rank
from .api.ranking import Ranking as Ranking
from .api.signals import open_results as open_results, stream as stream, synthesize as synthesize
from .core.body.body import Body as Body
from .core.body.shapes import shaped as shaped
from .core.imu.formats import read_recording as read_recording, write_recording as write_recording
from .core.imu.presets import preset as preset, read_sensor as read_sensor
from .core.imu.recording import ImuRecording as ImuRecording
from .core.imu.recordings import Recordings as Recordings
from .core.imu.sensor import SensorModel as SensorModel
from .core.imu.synthesis import Synthesis as Synthesis
from .core.keypoints.facts import PoseFacts as PoseFacts
from .core.motion.motion import Motion as Motion
from .core.patches.own_placements import patches_at as patches_at
from .core.patches.patches import PatchSet as PatchSet, sample_patches as sample_patches
from .core.ranking.agreement import rank_agreement as rank_agreement
from .core.ranking.classifiers.estimator import EstimatorClassifier as EstimatorClassifier
from .core.ranking.utility import UtilityMap as UtilityMap
from .core.selection.constraints import Constraints as Constraints
from .core.windows.windows import WindowSpec as WindowSpec

__version__: str

def register() -> None: ...
def unregister() -> None: ...
