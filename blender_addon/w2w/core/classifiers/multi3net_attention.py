# SPDX-License-Identifier: GPL-3.0-or-later
"""Attention among few tokens of many windows, where matrix products are too small to pay.

Windows lie innermost, so that every operation runs over all of them; sums are accumulated in
place, term by term, and nothing larger than the attention itself is ever formed.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor


def attention_among_few(query: Tensor, key: Tensor, value: Tensor, dropout: Tensor | None = None) -> Tensor:
    """Scaled dot-product attention (Vaswani et al. 2017).

    Parameters
    ----------
    query, key, value : Tensor, shape (P, heads, E, T, B)
        Of P places, E numbers of T tokens in each of B windows.
    dropout : Tensor, shape (heads, T, T, B), optional
        Factors of the attention of each token (first) to each other.

    Returns
    -------
    Tensor, shape (P, heads, E, T, B)
    """
    if dropout is None:
        dropout = query.new_ones(1)
    return _Attention.apply(query, key, value, dropout)[0]


class _Attention(torch.autograd.Function):
    generate_vmap_rule = True

    @staticmethod
    def forward(query: Tensor, key: Tensor, value: Tensor, dropout: Tensor) -> tuple[Tensor, Tensor]:
        attention = torch.softmax(_compare(query, key) / math.sqrt(query.shape[2]), dim=3)
        return _blend(attention * dropout, value), attention

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Tensor, ...], output: tuple[Tensor, Tensor]) -> None:
        ctx.mark_non_differentiable(output[1])
        ctx.save_for_backward(*inputs, output[1])

    @staticmethod
    def backward(ctx: Any, slope: Tensor, _: Tensor) -> tuple[Tensor | None, ...]:
        query, key, value, dropout, attention = ctx.saved_tensors
        of_value = _blend((attention * dropout).transpose(2, 3), slope)
        weighed = _compare(slope, value).mul_(dropout).mul_(attention)
        weighed = weighed.addcmul_(attention, weighed.sum(dim=3, keepdim=True), value=-1)
        weighed = weighed.div_(math.sqrt(query.shape[2]))
        return _blend(weighed, key), _blend(weighed.transpose(2, 3), query), of_value, None


def _compare(first: Tensor, second: Tensor) -> Tensor:
    """Dot products of tokens, (P, heads, T, T, B), of two (P, heads, E, T, B)."""
    total = first[:, :, 0, :, None] * second[:, :, 0, None]
    for number in range(1, first.shape[2]):
        total.addcmul_(first[:, :, number, :, None], second[:, :, number, None])
    return total


def _blend(weights: Tensor, tokens: Tensor) -> Tensor:
    """Sums of tokens (P, heads, E, T, B) by weights (P, heads, T, T, B)."""
    total = weights[:, :, None, :, 0] * tokens[:, :, :, :1]
    for number in range(1, tokens.shape[3]):
        total.addcmul_(weights[:, :, None, :, number], tokens[:, :, :, number : number + 1])
    return total
