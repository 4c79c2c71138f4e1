# SPDX-License-Identifier: GPL-3.0-or-later
"""Spots: the same place again from per cents and from the string, on bodies of any stature and build."""

import numpy as np
import pytest

from w2w.core.body.regions import regions_of
from w2w.core.body.shapes import shaped
from w2w.core.patches.naming import place
from w2w.core.patches.patches import PATCH_ORDER
from w2w.core.patches.spots import Spot, _aside, locate, vertex_at
from w2w.core.patches.tape_segments import segments_of

BUILDS = ({"gender": -1.0}, {"gender": 1.0, "muscle": 0.8}, {"arms": 1.1, "legs": 1.1})
STATURES = (1.40, 1.60, 1.75, 1.90, 2.10)
CENTRES = np.load(PATCH_ORDER)[:512].tolist()


def body_of(bundled_body, stature, build):
    if stature == 1.40 and build.get("gender") != -1:
        build = {"arms": 0.9, "legs": 0.9, "gender": build.get("gender", 0.0)}  # so short only with these
    if stature == 1.60 or stature == 1.75:
        build = {**build, "weight": 90.0 if "muscle" in build else 52.0}
    return shaped(bundled_body, height=stature, **build)


WRITTEN = 0.1
"""Per cents to which a spot is written: a tape reads no more."""


def point_at(body, spot):
    """The point of the skin at a spot: three vertices (3,) of a triangle and its shares (3,) of them.

    It is on a triangle of the vertex that `vertex_at` takes, whose errors it raises: elsewhere, folds of the
    skin may have the same per cents.
    """
    segment = segments_of(body)[spot.segment]
    nearest = vertex_at(body, spot)
    close = _aside(segment, body.vertices[nearest][None], spot)[0]
    if np.abs(close).max() < WRITTEN / 100 * max(segment.length, segment.girth(spot.along)):
        return np.full(3, nearest), np.array([1.0, 0.0, 0.0])
    faces = body.faces[(body.faces == nearest).any(axis=1)]
    corners = _aside(segment, body.vertices[faces].reshape(-1, 3), spot).reshape(-1, 3, 2)
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
    whole = areas.sum(axis=1)
    shares = np.divide(areas, whole[:, None], out=np.full_like(areas, -1), where=whole[:, None] != 0)
    # a triangle that spans the far side of the circumference is no triangle in per cents
    spans = np.ptp(corners[:, :, 1], axis=1) > 0.5 * segment.girth(spot.along)
    inside = np.flatnonzero((shares > -1e-9).all(axis=1) & ~spans)
    if len(inside) == 0:
        return np.full(3, nearest), np.array([1.0, 0.0, 0.0])
    points = np.einsum("fk,fka->fa", shares[inside], body.vertices[faces[inside]])
    best = inside[np.linalg.norm(points - body.vertices[nearest], axis=1).argmin()]
    return faces[best], shares[best]


def cross(first, second):
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]


def aside(body, vertex):
    """How far a vertex and a point come back from the vertex's string, per cent of its segment's length."""
    spot = Spot.parse(str(locate(body, vertex)))
    corners, shares = point_at(body, spot)
    came_back = np.stack([body.vertices[vertex_at(body, spot)], shares @ body.vertices[corners]])
    length = segments_of(body)[spot.segment].length
    return 100 * np.linalg.norm(came_back - body.vertices[vertex], axis=1) / length


EVERY = [(stature, build) for stature in STATURES for build in BUILDS]


@pytest.mark.slow
@pytest.mark.parametrize(("stature", "build"), EVERY)
def test_every_patch_comes_back_on_bodies_of_any_stature_and_build(bundled_body, stature, build):
    body = body_of(bundled_body, stature, build)
    assert np.max([aside(body, vertex) for vertex in CENTRES]) < 1


@pytest.mark.slow
def test_a_spot_is_the_same_place_on_another_body(bundled_body):
    other = shaped(bundled_body, gender=1, height=2.0)
    limbs = [v for v in CENTRES if "arm" in locate(bundled_body, v).segment]
    away = [
        np.linalg.norm(other.vertices[vertex_at(other, locate(bundled_body, v))] - other.vertices[v])
        for v in limbs
    ]
    assert np.median(away) < 0.015


@pytest.mark.parametrize("text", ["left forearm 85% 50%", "chest 30% 0%", "right lower leg -2.5% 99.9%"])
def test_the_string_parses_back(text):
    assert str(Spot.parse(text)) == text
    assert Spot.parse(f"  {text.upper()} ") == Spot.parse(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("left forearm", r"write a segment, the per cent along it .*'left forearm 85% 50%'"),
        ("left forearm 8.5.1% 50%", "is no spot"),
        ("forearm 85% 50%", "'left forearm' or 'right forearm'"),
        ("left forarm 85% 50%", "did you mean left forearm"),
        ("tail 85% 50%", "there are head, neck, chest"),
        ("left forearm 850% 50%", "0 is elbow crease and 100 wrist crease"),
        ("left forearm 85% 150%", "from 0 to 100 %"),
    ],
)
def test_a_string_that_is_no_spot_says_what_to_write(text, message):
    with pytest.raises(ValueError, match=message):
        Spot.parse(text)


def test_a_spot_where_there_is_no_skin_is_refused(bundled_body):
    with pytest.raises(ValueError, match="has no skin there"):
        vertex_at(bundled_body, Spot("left forearm", 200, 50))


@pytest.mark.parametrize(
    ("text", "region"),
    [
        # the examples of the proposal's table, in our per cents: along from the proximal landmark
        ("head 50% 50%", "back of head"),
        ("chest 30% 0%", "sternum"),
        ("right upper arm 30% 25%", "right upper arm lateral"),
        ("left upper arm 30% 25%", "left upper arm lateral"),
        ("right forearm 70% 50%", "right forearm dorsal"),
        ("left forearm 70% 50%", "left forearm dorsal"),
        ("right thigh 50% 25%", "right thigh lateral"),
        ("left lower leg 20% 25%", "left lower leg lateral"),
        ("left lower leg 80% 25%", "left lower leg lateral"),
        ("right foot 60% 0%", "right instep"),
        # and other places that a person would describe so
        ("left forearm 97% 50%", "left wrist dorsal"),
        ("left forearm 97% 0%", "left wrist volar"),
        ("right forearm 97% 25%", "right wrist thumb side"),
        ("right hand 30% 0%", "right palm"),
        ("right thigh 50% 0%", "right thigh front"),
        ("left lower leg 40% 50%", "left calf"),
        ("left lower leg 97% 25%", "left ankle lateral"),
        ("abdomen 100% 0%", "navel"),
        ("pelvis 10% 50%", "lower spine"),
        ("pelvis 100% 50%", "sacrum"),
        ("abdomen 50% 25%", "left lateral oblique"),
        ("head 80% 0%", "forehead"),
        ("neck 50% 50%", "nape"),
    ],
)
def test_spots_lie_in_the_regions_named(bundled_body, text, region):
    codes, names = regions_of(bundled_body)
    assert names[codes[vertex_at(bundled_body, Spot.parse(text))]] == region


def test_placements_by_name_have_the_spots_a_person_would_give(bundled_body):
    watch, chest = locate(bundled_body, place("left wrist", bundled_body)), place("chest", bundled_body)
    assert watch.segment == "left forearm"
    assert 90 < watch.along <= 100
    assert 40 < watch.around < 60
    assert locate(bundled_body, chest).segment == "chest"
    assert min(locate(bundled_body, chest).around % 100, 100 - locate(bundled_body, chest).around) < 3


def test_left_and_right_mirror_each_other(bundled_body):
    for vertex in CENTRES:
        spot, image = locate(bundled_body, vertex), locate(bundled_body, int(bundled_body.mirror[vertex]))
        assert image.along == pytest.approx(spot.along, abs=1e-6)
        if spot.segment.startswith(("left", "right")):
            assert image.segment.split(" ")[1:] == spot.segment.split(" ")[1:]
            assert (image.segment == spot.segment) == (image == spot)
            assert image.around == pytest.approx(spot.around, abs=0.05)
        else:
            assert (image.around + spot.around + 1) % 100 == pytest.approx(1, abs=0.05)


def test_a_point_between_vertices_is_found_by_its_per_cents(bundled_body):
    corners, shares = point_at(bundled_body, Spot("left forearm", 50, 40))
    assert shares.sum() == pytest.approx(1)
    point = shares @ bundled_body.vertices[corners]
    back = locate(bundled_body, int(corners[0])).segment
    ((along,), (around,)) = segments_of(bundled_body)[back].coordinates(point[None])
    assert (back, along) == ("left forearm", pytest.approx(50, abs=0.5))
    assert around == pytest.approx(40, abs=0.5)


@pytest.mark.parametrize(
    ("spot", "words"),
    [
        (("right thigh", 40, 25), "40 % of the way from hip bone (trochanter) to knee crease, outer side"),
        (("left forearm", 85, 50), "85 % of the way from elbow crease to wrist crease, back of the arm"),
        (("left hand", 20, 99), "20 % of the way from wrist crease to tip of the middle finger, palm"),
        (
            ("abdomen", 70, 12),
            "70 % of the way from tip of the breastbone to navel, between front and left side",
        ),
        (
            ("pelvis", 120, 50),
            "20 % of the way from navel to pubic bone beyond pubic bone, back of the trunk",
        ),
        (
            ("head", -5, 0),
            "5 % of the way from chin to crown of the head, but beyond chin, front of the head",
        ),
    ],
)
def test_words_for_a_person_with_a_tape(spot, words):
    assert Spot(*spot).in_words() == f"{spot[0]}, {words}"


@pytest.mark.parametrize("text", ["1" * 2**20, "1." * 2**19, "left forearm " + "1 " * 2**19 + "%"], ids=len)
def test_a_spot_is_searched_once_however_long_it_is(text):
    """A million digits were gone over for each of them, which took hours."""
    with pytest.raises(ValueError, match="1"):
        Spot.parse(text)
