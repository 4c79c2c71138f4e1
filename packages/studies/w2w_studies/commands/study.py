# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study`: the paper's studies, for anyone to run."""

import typer

from .study_copies import copies
from .study_library import library
from .study_mixamo import mixamo
from .study_need import need
from .study_paper import paper
from .study_pilot import pilot
from .study_prior import prior
from .study_rehab import rehab
from .study_repeatability import repeatability
from .study_truth import truth

STUDY = typer.Typer(no_args_is_help=True, help="Run one of the paper's studies.")
STUDY.command()(rehab)
STUDY.command()(mixamo)
STUDY.command()(library)
STUDY.command()(truth)
STUDY.command()(paper)
STUDY.command()(pilot)
STUDY.command()(repeatability)
STUDY.command()(copies)
STUDY.command()(need)
STUDY.command()(prior)
