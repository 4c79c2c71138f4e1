# SPDX-License-Identifier: GPL-3.0-or-later
"""What an answer's places would reach on other clips in a stream, where windows fall as they fall."""

from dataclasses import dataclass
from typing import Self

from ..ranking.stream import ExpectedF1, Stream
from .answer import Answer
from .headline import short


@dataclass(frozen=True)
class InStream:
    """Expected F1 of one sensor in a stream."""

    answer: ExpectedF1  # at the recommended place
    products: tuple[ExpectedF1, ...]  # on each product of the answer

    @classmethod
    def of(cls, stream: Stream, answer: Answer) -> Self:
        """What the places of an answer would reach in a stream."""
        patches = [answer.patch, *(score.patch for score in answer.products)]
        cut_out = [ExpectedF1(of.expected, of.low, of.high) for of in answer.products]
        cut_out.insert(0, ExpectedF1(answer.expected, answer.low, answer.high))
        stream.f1([[patch] for patch in patches])  # all at once: their signals are read once
        first, *others = (stream.expected([patch], of) for patch, of in zip(patches, cut_out, strict=True))
        return cls(first, tuple(others))

    def sentence(self) -> str:
        """Say in words what the recommended place would reach."""
        mean, low, high = map(short, self.answer)
        return (
            f"In a stream of other clips, with standing between them, F1 of one sensor there is {mean} "
            f"({low} to {high}); all other F1 of one sensor is on clips cut out"
        )
