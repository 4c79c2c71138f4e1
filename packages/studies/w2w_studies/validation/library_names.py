# SPDX-License-Identifier: GPL-3.0-or-later
"""What public motion libraries call their clips, and what we call it: one set of activities over all of them.

A source's name becomes our activity where both mean the same movement; wherever one says more than the other
(with which hand, to which side) they stay apart. Names that no rule holds are left out.
"""

from .mhad import BANDAI, HDM05, MIXAMO
from .protocol import Rule
from .umafall import CMU

AMASS = "AMASS"

_HDM05 = {
    "squat": "squat",
    "hop": "hop",
    "pick_up": "pick up",
    "kick": "kick",
    "reach_up": "reach up",
    "elbow_to_knee": "elbow to knee",
    "lie_down": "lie down",
    "jog": "run",
    "rotate_arms": "rotate arms",
    "sneak": "sneak",
    "throw": "throw",
}
"""Folders of HDM05's clips; performers are named by the file."""

_BANDAI = {
    "walk": "walk",
    "run": "run",
    "dash": "run",
    "walk-back": "walk backwards",
    "walk-left": "step left",
    "walk-right": "step right",
    "walk-turn-left": "turn left",
    "walk-turn-right": "turn right",
    "raise-up-both-hands": "raise both hands",
    "raise-up-left-hand": "raise left hand",
    "raise-up-right-hand": "raise right hand",
    "wave-both-hands": "wave both hands",
    "wave-left-hand": "wave left hand",
    "wave-right-hand": "wave right hand",
    "bow": "bow",
    "bye": "say goodbye",
    "byebye": "say goodbye",
    "dance-short": "dance",
    "guide": "show the way",
    "kick": "kick",
    "punch": "punch",
    "slash": "slash",
    "call": "phone call",
}
"""Actions in the names of Bandai-Namco's files; its three actors are not named, so styles stand for them."""

_MIXAMO = {
    r"(aj@|unarmed |start |strut)?walk(ing)?( forward)?(_inplace)?": "walk",
    r"(fast |new_bull_)?run(ning)?(_inplace)?": "run",
    r"sneak walk": "sneak",
    r"(walk with rifle|carrying|right turn w briefcase|running_inplace_with_sword_right)": "carry",
    r"((catwalk )?walk(ing)? turn 180( tight)?|running turn 180|catwalk twist l to walk 180|running to turn|"
    r"change direction)": "turn around",
    r"(ascending stairs|running up stairs)": "climb stairs",
    r"(sit to stand|crouch to stand)": "stand up",
    r"stand to sit": "sit down",
    r"((unarmed )?idle( 01)?|breathing idle)": "stand",
    r"drunk[ _]idle([ _]variation)?": "sway",
    r"crouch(ing)?[ _]idle": "crouch",
    r"(kneeling ?(pointing|inspecting)|pistol kneeling idle)": "kneel",
    r"crawling(_inplace)?": "crawl",
    r"air ?squat": "squat",
    r"pistol( start)?": "squat on one leg",
    r"(mma ?kick|roundhouse kick|hurricane ?kick|kicking_(left|right)|capoeira)": "kick",
    r"punch(ing)?": "punch",
    r"throw (object|grenade)": "throw",
    r"(cutting|standing_melee_attack_downward_(left|right))": "slash",
    r"baseball hit(-2)?": "swing a bat",
    r"(great sword high spin attack|standing melee attack 360 high|spin in place)": "spin",
    r"(digging|dig and plant seeds)": "dig",
    r"(pullplant|pick fruit)": "pick fruit",
    r"(aj@)?(push|pull heavy object)": "push or pull",
    r"clapping": "clap",
    r"waving": "wave",
    r"standing ?greeting": "greet",
    r"(sitting and )?pointing": "point",
    r"drinking": "drink",
    r"eat(ing)?": "eat",
}
"""Whole names of Mixamo's files, less the number of a repeated download; nobody is named."""

_CMU = (
    (r"0?(?P<who>06)_(0[4-68-9]|15)", "dribble a ball"),
    (r"0?(?P<who>06)_01", "walk"),
    (r"0?(?P<who>07)_12", "walk"),
    (r"0?(?P<who>02)_03", "run"),
)
"""Subject and trial, which the collection's index describes."""

RULES = (
    *(
        Rule(ours, HDM05, rf"(^|/){theirs}/(?P<who>bd|bk|dg|mm|tr)_[^/]*\.(bvh|amc|c3d)$")
        for theirs, ours in _HDM05.items()
    ),
    *(
        Rule(ours, BANDAI, rf"(^|/)dataset-\d_{theirs}_(?P<who>[a-z-]+)_\d+\.bvh$")
        for theirs, ours in _BANDAI.items()
    ),
    *(Rule(ours, MIXAMO, rf"(^|/){theirs}( \(\d+\))?\.fbx$") for theirs, ours in _MIXAMO.items()),
    *(Rule(ours, CMU, rf"(^|/)({theirs})\.bvh$") for theirs, ours in _CMU),
    Rule("run", AMASS, r"(^|/)hbertiche__NeuralClothSim/0000\.npz$"),
)
