# SPDX-License-Identifier: GPL-3.0-or-later
"""Names as BIDS allows them; whole datasets are written by tests/headless/commands/test_export.py."""

from w2w.core.exports.bids import labels_of


def test_bids_labels_are_letters_and_digits_and_distinct():
    assert labels_of(["a_b", "ab"]) == {"a_b": "aB", "ab": "ab2"}
    found = labels_of(["sit to stand", "Sit-to-stand!", "走", "跑", "a_b", "ab"])
    assert all(label.isalnum() and label.isascii() for label in found.values())
    assert len({label.lower() for label in found.values()}) == 6
