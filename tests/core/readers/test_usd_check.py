# SPDX-License-Identifier: GPL-3.0-or-later
"""What a USD file says of itself as text; what is no whole file is refused."""

import sys

import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.import_checks import check_usd

HEADER = "#usda 1.0\n(\n    timeCodesPerSecond = 30\n)\n"
BODY = 'def Xform "a"\n{\n}\n'


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        (HEADER + BODY, 30.0),
        (HEADER.replace("30", "29.97") + BODY, 29.97),
        ("#usda 1.0\n(\n    framesPerSecond = 60\n)\n" + BODY, 60.0),
        ("#usda 1.0\n(\n    framesPerSecond = 60\n    timeCodesPerSecond = 120\n)\n" + BODY, 120.0),
        ("#usda 1.0\n" + BODY, 24.0),
    ],
)
def test_text_says_its_time_codes_a_second(tmp_path, text, rate):
    (tmp_path / "a.usd").write_text(text)
    assert check_usd(tmp_path / "a.usd") == rate


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.usda", b"", "empty"),
        ("a.usda", b"nothing of the kind", "it does not begin as one"),
        ("a.usdc", b"PXR", "it does not begin as one"),
        ("a.usda", (HEADER + BODY).encode()[:-4], "it is cut short"),
        ("a.usda", HEADER.replace("30", "-1").encode() + BODY.encode(), "has -1 time codes a second"),
        ("a.usda", HEADER.replace("30", "many").encode() + BODY.encode(), "has many time codes"),
        (
            "a.usda",
            (HEADER + 'def "a" (\n    references = @../../etc/rig.usd@</rig>\n)\n{\n}\n').encode(),
            "parts of it lie in other files (../../etc/rig.usd)",
        ),
        (
            "a.usda",
            b"#usda 1.0\n(\n    subLayers = [\n        @b.usd@\n    ]\n)\n" + BODY.encode(),
            "(b.usd)",
        ),
    ],
)
def test_what_is_no_whole_file_is_refused(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UnusableMotion) as caught:
        check_usd(tmp_path / name)
    assert message in str(caught.value)


@pytest.mark.parametrize("head", [b"PXR-USDC", b"PK\x03\x04"])
def test_a_binary_file_wants_usd_itself(tmp_path, monkeypatch, head):
    monkeypatch.setitem(sys.modules, "pxr", None)
    (tmp_path / "a.usdz").write_bytes(head + b"\0" * 200)
    with pytest.raises(UnusableMotion, match=r"use Blender 4\.4 or later, or save it as text, \.usda"):
        check_usd(tmp_path / "a.usdz")


def test_a_text_is_searched_once_however_long_its_lines_are(tmp_path):
    """A million letters were gone over for each of them, which took hours."""
    path = tmp_path / "long.usda"
    path.write_text("#usda 1.0\n(\n" + "\n" * 2**18 + ")\n" + "references=" * 2**18 + "\n}\n")
    assert check_usd(path) == 24.0
