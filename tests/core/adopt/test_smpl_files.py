# SPDX-License-Identifier: GPL-3.0-or-later
"""Official SMPL files of the very format, none of them executed, and files that are none."""

import io
import pickle
import pickletools
import struct
import sys
import types
from typing import ClassVar

import numpy as np
import pytest
from scipy import sparse

from w2w.core.adopt.smpl import BodyError, load_body
from w2w.core.body.body import JOINT_INDEX, N_JOINTS, PARENTS, Y_UP_TO_Z_UP
from w2w.core.files import UNPACKED_FREELY
from w2w.core.pickles import RefusedPickleError, read_npz_member

from ...rings import by_day

OFFICIAL_NAMES = {
    "__builtin__ set", "chumpy.ch Ch", "chumpy.reordering Select", "numpy dtype", "numpy ndarray",
    "numpy.core.multiarray _reconstruct", "scipy.sparse.csc csc_matrix",
}  # fmt: skip
"""What the released SMPL and MANO pickles name, and nothing else."""


class Python2Pickler(pickle._Pickler):
    """Writes bytes as Python 2 wrote its strings, as in the official files."""

    def save_bytes(self, value):
        self.write(b"T" + struct.pack("<i", len(value)) + value)
        self.memoize(value)

    dispatch: ClassVar = pickle._Pickler.dispatch | {bytes: save_bytes}


@pytest.fixture
def chumpy(monkeypatch):
    """Stands for chumpy, which stopped working on Python 3.11: its classes by name, with their state."""
    modules = {name: types.ModuleType(name) for name in ("chumpy", "chumpy.ch", "chumpy.reordering")}
    for module, name in (("chumpy.ch", "Ch"), ("chumpy.reordering", "Select")):
        setattr(modules[module], name, type(name, (), {"__module__": module}))
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    return modules


@pytest.fixture
def model(bundled_body):
    """The arrays of an official model, made of the bundled body."""
    regressor = sparse.lil_matrix((N_JOINTS, len(bundled_body.vertices)))
    generator = np.random.default_rng(3)
    for joint in range(N_JOINTS):
        chosen = generator.choice(len(bundled_body.vertices), 20, replace=False)
        regressor[joint, chosen] = generator.dirichlet(np.ones(20))
    parents = np.array(PARENTS, dtype=np.int64).astype(np.uint32)  # the root's -1 is 4294967295 in the files
    return {
        "v_template": bundled_body.vertices @ Y_UP_TO_Z_UP,
        "f": bundled_body.faces.astype(np.uint32),
        "J_regressor": sparse.csc_matrix(regressor),
        "weights": bundled_body.weights,
        "kintree_table": np.array([parents, np.arange(N_JOINTS, dtype=np.uint32)]),
        "shapedirs": generator.normal(size=(len(bundled_body.vertices), 3, 2)),
        "posedirs": np.zeros((len(bundled_body.vertices), 3, 4)),
        "bs_style": "lbs",
    }


def write_official_pickle(path, model, chumpy, protocol):
    arrays = dict(model)
    wrapped = chumpy["chumpy.ch"].Ch()
    wrapped.__dict__.update(x=model["v_template"], _dirty_vars=set(), _itr=None, _depends_on_deps={})
    chosen = chumpy["chumpy.reordering"].Select()
    flat = model["shapedirs"]
    chosen.__dict__.update(a=flat, idxs=np.arange(flat.size), preferred_shape=np.array(flat.shape))
    arrays |= {"v_template": wrapped, "shapedirs": chosen}
    stream = io.BytesIO()
    (Python2Pickler if protocol == 2 else pickle._Pickler)(stream, protocol).dump(arrays)
    content = stream.getvalue().replace(b"scipy.sparse._csc", b"scipy.sparse.csc")
    named = {arg for code, arg, _ in pickletools.genops(content) if code.name == "GLOBAL"}
    assert named >= OFFICIAL_NAMES
    path.write_bytes(content)


def check_official(body, model):
    expected = model["v_template"] @ Y_UP_TO_Z_UP.T
    joints = np.asarray(model["J_regressor"] @ model["v_template"]) @ Y_UP_TO_Z_UP.T
    shift = body.joints[0] - joints[0]
    np.testing.assert_allclose(body.vertices - shift, expected, atol=1e-12)
    np.testing.assert_allclose(body.joints - shift, joints, atol=1e-12)
    np.testing.assert_allclose(body.weights, model["weights"], atol=1e-12)
    np.testing.assert_array_equal(body.faces, model["f"])
    assert body.vertices[:, 2].min() == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(body.joints[0, :2], 0, atol=1e-12)


@pytest.mark.parametrize("protocol", by_day([2], [0, 2]))
def test_an_official_pickle(tmp_path, model, chumpy, protocol):
    path = tmp_path / "basicModel_f_lbs_10_207_0_v1.0.0.pkl"
    write_official_pickle(path, model, chumpy, protocol)
    body = load_body(path)
    check_official(body, model)
    assert body.name == path.stem


@pytest.mark.parametrize("as_object", by_day([True], [False, True]))
def test_an_official_npz(tmp_path, model, as_object):
    """Some releases keep the sparse regressor as a pickled object inside the npz."""
    regressor = model["J_regressor"]
    stored = np.array(regressor, dtype=object) if as_object else regressor.toarray()
    np.savez(tmp_path / "SMPL_NEUTRAL.npz", **(model | {"J_regressor": stored}))
    check_official(load_body(tmp_path / "SMPL_NEUTRAL.npz"), model)


@pytest.mark.slow
def test_betas_shape_an_official_model_and_its_joints(tmp_path, model, chumpy):
    path = tmp_path / "SMPL_NEUTRAL.pkl"
    model["shapedirs"] *= 0.01
    write_official_pickle(path, model, chumpy, 2)
    betas = np.array([1.5, -2.0])
    shaped = model | {"v_template": model["v_template"] + model["shapedirs"] @ betas}
    check_official(load_body(path, betas), shaped)
    check_official(load_body(path, betas[:1]), model | {
        "v_template": model["v_template"] + 1.5 * model["shapedirs"][..., 0]
    })  # fmt: skip
    with pytest.raises(BodyError, match="at most 2 finite numbers"):
        load_body(path, np.ones(3))
    with pytest.raises(BodyError, match="at most 2 finite numbers"):
        load_body(path, np.array([np.nan]))


def test_betas_need_directions_to_act_along(tmp_path, model, bundled_body):
    arrays = {name: value for name, value in model.items() if name != "shapedirs"}
    np.savez(tmp_path / "a.npz", **(arrays | {"J_regressor": model["J_regressor"].toarray()}))
    with pytest.raises(BodyError, match="lacks shapedirs"):
        load_body(tmp_path / "a.npz", np.ones(2))
    bundled_body.save(tmp_path / "own.npz")
    with pytest.raises(BodyError, match="a shape of its own"):
        load_body(tmp_path / "own.npz", np.ones(2))


def test_fingers_of_smpl_h_go_to_the_hands(tmp_path, model):
    fingers = [20, 22, 23, 20, 25, 26, 20, 28, 29, 20, 31, 32, 20, 34, 35]
    parents = [*PARENTS[:22], *fingers, *(21 if parent == 20 else parent + 15 for parent in fingers)]
    weights = np.zeros((len(model["weights"]), 52))
    weights[:, :22] = model["weights"][:, :22]
    weights[:, 25], weights[:, 24] = 0.75 * model["weights"][:, 22], 0.25 * model["weights"][:, 22]
    weights[:, 41] = model["weights"][:, 23]
    regressor = np.zeros((52, weights.shape[0]))
    regressor[:22] = model["J_regressor"].toarray()[:22]
    regressor[np.arange(22, 52), np.arange(30) * 100] = 1
    table = np.array([parents, range(52)])
    changed = model | {"weights": weights, "J_regressor": regressor, "kintree_table": table}
    np.savez(tmp_path / "SMPLH_MALE.npz", **changed)
    body = load_body(tmp_path / "SMPLH_MALE.npz")
    np.testing.assert_allclose(body.weights, model["weights"], atol=1e-12)
    knuckles = body.vertices[(np.flatnonzero(np.array(parents) == 20) - 22) * 100]
    np.testing.assert_allclose(body.joints[JOINT_INDEX["left_hand"]], knuckles.mean(axis=0), atol=1e-12)


class Evil:
    def __init__(self, function, *arguments):
        self.call = function, arguments

    def __reduce__(self):
        return self.call


def evil_pickles(target):
    import os

    command = f"touch {target}"
    return {
        "os.system": Evil(os.system, command),
        "eval": Evil(eval, f"open({str(target)!r}, 'w')"),
        "getattr": Evil(getattr, command, "upper"),
        "numpy.load": Evil(np.load, str(target)),
        "inside an object array": np.array([Evil(os.system, command)], dtype=object),
        "as a chumpy value": {"v_template": Evil(os.system, command)},
    }


@pytest.mark.parametrize("name", list(evil_pickles("x")))
@pytest.mark.parametrize("protocol", [0, 2, 4])
def test_a_malicious_pickle_is_refused_and_runs_nothing(tmp_path, name, protocol):
    target = tmp_path / "executed"
    path = tmp_path / "SMPL_FEMALE.pkl"
    path.write_bytes(pickle.dumps({"v_template": evil_pickles(target)[name]}, protocol))
    with pytest.raises(BodyError, match=r"SMPL_FEMALE\.pkl: it names .*arrays only"):
        load_body(path)
    assert not target.exists()


def test_a_malicious_object_array_in_an_npz_is_refused(tmp_path, model):
    target = tmp_path / "executed"
    evil = np.array([evil_pickles(target)["os.system"]], dtype=object)
    np.savez(tmp_path / "SMPL_MALE.npz", **(model | {"J_regressor": evil}))
    with pytest.raises(BodyError, match=r"it names posix\.system"):
        load_body(tmp_path / "SMPL_MALE.npz")
    assert not target.exists()


def test_a_sparse_matrix_may_not_point_outside_itself(tmp_path, model):
    """Indices out of range would read and write memory that is not the matrix's."""
    bad = model["J_regressor"].copy()
    bad.indices[0] = 10**6
    (tmp_path / "bad.pkl").write_bytes(pickle.dumps(model | {"J_regressor": bad}, 2))
    with pytest.raises(BodyError, match=r"bad\.pkl"):
        load_body(tmp_path / "bad.pkl")


def test_reading_a_pickle_leaves_numpy_s_types_alone(tmp_path):
    """A type's state follows its name in a pickle: given to the shared type it would change all arrays."""
    swapped = np.arange(4, dtype=">f8")
    (tmp_path / "a.pkl").write_bytes(pickle.dumps({"v_template": swapped}, 2))
    with pytest.raises(BodyError):
        load_body(tmp_path / "a.pkl")
    assert np.dtype("f8").byteorder == "="
    assert np.arange(3.0).tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"weights": None}, "lacks weights"),
        ({"v_template": np.zeros((5, 3))}, "'J_regressor' has shape"),
        ({"v_template": np.zeros(5)}, "'v_template' is no table"),
        ({"kintree_table": np.zeros((2, 24), int)}, "not joined like SMPL's 24"),
    ],
)
def test_models_that_are_none_are_refused_in_words(tmp_path, model, change, words):
    changed = {key: value for key, value in (model | change).items() if value is not None}
    (tmp_path / "model.pkl").write_bytes(pickle.dumps(changed, 2))
    with pytest.raises(BodyError, match=words):
        load_body(tmp_path / "model.pkl")


def test_other_files_are_refused_in_words(tmp_path):
    for name, content, words in (
        ("list.pkl", pickle.dumps([1, 2]), "holds a list"),
        ("cut.pkl", b"\x80\x02}q\x00(U", "no pickle of a model"),
        ("text.npz", b"hello", "text.npz"),
        ("empty.obj", b"# nothing\n", "holds no mesh"),
        ("word.obj", b"v 0 0 zero\n", "line 1"),
        ("far.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "name vertices that it does not hold"),
        ("five.obj", b"v 0 0 0\n" * 5 + b"f 1 2 3 4 5\n", "faces of 5 to 5 corners"),
        ("word.ply", b"plywood", "not a PLY file"),
        ("body.glb", b"glTF", "hold no body that can be read here"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(BodyError, match=words):
            load_body(tmp_path / name)
    with pytest.raises(BodyError, match="is not there"):
        load_body(tmp_path / "none.pkl")


@pytest.mark.slow
def test_a_mesh_of_another_kind_says_what_was_expected_and_found(tmp_path, bundled_body):
    cube = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    sides = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    (tmp_path / "cube.obj").write_text(cube + "".join(f"f {side}\n" for side in sides))
    with pytest.raises(BodyError, match=r"expected 6890 vertices and 13776 tri.*found 8 vertices and 12 tri"):
        load_body(tmp_path / "cube.obj")
    lines = [f"v {x} {y} {z}" for x, y, z in bundled_body.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in bundled_body.faces + 1]
    (tmp_path / "ours.obj").write_text("\n".join(lines))
    with pytest.raises(BodyError, match="joined in another way"):
        load_body(tmp_path / "ours.obj")


def test_a_body_w2w_saved_comes_back(tmp_path, bundled_body):
    bundled_body.save(tmp_path / "ours.npz")
    np.testing.assert_array_equal(load_body(tmp_path / "ours.npz").vertices, bundled_body.vertices)


def test_a_pickled_member_that_unpacks_to_far_more_than_a_model_holds_is_refused_unread(tmp_path):
    held = np.empty((), dtype=object)
    held[()] = np.zeros(UNPACKED_FREELY // 8 + 1)
    np.savez_compressed(tmp_path / "bomb.npz", J_regressor=held)
    with pytest.raises(RefusedPickleError, match=r"it would unpack to 0\.1 GiB, which no model does"):
        read_npz_member(tmp_path / "bomb.npz", "J_regressor")
