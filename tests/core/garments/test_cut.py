"""T-shirt and trousers are cut for any body: loose, in one piece, held at collar or waistband."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from w2w.core.body.shapes import shaped
from w2w.core.garments.cut import EASE, KINDS, cut, split_name


@pytest.fixture(scope="module", params=KINDS)
def garment(request, bundled_body):
    return cut(request.param, bundled_body)


def depth(cloth, body):
    near = KDTree(body.vertices).query(cloth.vertices)[1]
    return np.einsum("va,va->v", cloth.vertices - body.vertices[near], body.vertex_normals[near])


def openings(cloth):
    """Number of closed lines along which a mesh ends."""
    faces = cloth.faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    found, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    border = found[count == 1]
    graph = coo_matrix((np.ones(len(border)), border.T), shape=(len(cloth.vertices),) * 2)
    pieces = connected_components(graph, directed=False)[1]
    return len(np.unique(pieces[border]))


def test_it_is_loose_and_nowhere_in_the_skin(garment, bundled_body):
    found = depth(garment.cloth, bundled_body)
    assert found.min() > 0.002
    assert EASE * 0.8 < np.median(found) < EASE * 1.5


def test_it_has_the_openings_of_what_it_is(garment):
    assert openings(garment.cloth) == {"tshirt": 4, "trousers": 3}[garment.cloth.name]


def test_it_is_held_at_its_top_alone(garment, bundled_body):
    top = garment.cloth.vertices[garment.held]
    assert 20 < len(top) < 0.1 * len(garment.cloth.vertices)
    assert np.abs(top[:, 0]).max() < 0.22
    if garment.cloth.name == "tshirt":
        assert top[:, 2].min() > bundled_body.joints[16, 2] - 0.05
    else:
        assert top[:, 2].min() > garment.cloth.vertices[:, 2].max() - 0.06


def test_legs_do_not_run_into_each_other(bundled_body):
    cloth = cut("trousers", bundled_body).cloth
    low = cloth.vertices[:, 2] < bundled_body.joints[4, 2]
    crossing = np.sign(cloth.vertices[cloth.faces][..., 0])
    below = low[cloth.faces].all(axis=1)
    assert (np.abs(crossing[below].sum(axis=1)) == 3).all()


def test_its_triangles_face_outward_and_are_as_large_as_the_skins(garment, bundled_body):
    cloth = garment.cloth
    near = KDTree(bundled_body.vertices).query(cloth.vertices)[1]
    along = np.einsum("va,va->v", cloth.vertex_normals, bundled_body.vertex_normals[near])
    assert np.percentile(along, 5) > 0
    corners = cloth.vertices[cloth.faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert sides.max() < 0.08
    assert np.median(sides) > 0.015


@pytest.mark.parametrize("kind", KINDS)
def test_it_fits_bodies_of_other_shapes(kind, bundled_body):
    for shape in ({"gender": -1.0, "height": 1.5}, {"gender": 1.0, "weight": 110.0}):
        body = shaped(bundled_body, **shape)
        garment = cut(kind, body)
        # thighs of heavy bodies touch, and leave cloth between them no room
        assert np.percentile(depth(garment.cloth, body), 1) > 0.002
        assert openings(garment.cloth) == {"tshirt": 4, "trousers": 3}[kind]


def test_the_same_body_gives_the_same_bytes(bundled_body):
    first, second = (cut("tshirt", bundled_body) for _ in range(2))
    assert first.cloth.vertices.tobytes() == second.cloth.vertices.tobytes()
    assert first.held.tobytes() == second.held.tobytes()


def test_an_unknown_garment_is_named_with_those_that_there_are(bundled_body):
    with pytest.raises(ValueError, match="no garment called 'skirt': there are tshirt and trousers"):
        cut("skirt", bundled_body)


def test_a_garment_of_ones_own_is_a_file_and_an_object():
    assert split_name("wardrobe/my.blend:Hoodie: red") == ("wardrobe/my.blend", "Hoodie: red")
    assert split_name("tshirt") == ("", "tshirt")
