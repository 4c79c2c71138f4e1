# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings survive their file formats, peers read them, and real data sets come in as they are."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from w2w.core.imu import formats, vendor_formats
from w2w.core.imu.recording import ImuRecording
from w2w_studies.datasets.broad import read_broad
from w2w_studies.datasets.dsads import DSADS_SITES, read_dsads
from w2w_studies.datasets.gait import read_gait
from w2w_studies.datasets.utd_mhad import read_utd_mhad

from ...orientation_sto import read_orientation_sto

GAIT_TRIAL = "S02-Trial-Walk-1"
REUSE_FOLDER = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

values = st.one_of(st.floats(-2000, 2000, width=32), st.just(float("nan")))
texts = st.text(
    st.characters(exclude_categories=["Cs"], exclude_characters="\x00"), max_size=12
)  # numpy drops NULs


@st.composite
def recordings(draw) -> ImuRecording:
    n = draw(st.integers(2, 12))
    acc, gyr = (draw(arrays(np.float32, (n, 1, 3), elements=values)) for _ in range(2))
    rate = draw(st.sampled_from([25.0, 50.0, 60.0, 102.4, 200 / 0.7]))
    return ImuRecording(
        acc=acc, gyr=gyr, rate=rate, sites=(draw(texts) or "x",), activity=draw(texts), clip=draw(texts)
    )


@pytest.fixture
def walk() -> ImuRecording:
    rng = np.random.default_rng(0)
    return ImuRecording(
        acc=rng.normal(0, 10, (200, 3, 3)),
        gyr=rng.normal(0, 3, (200, 3, 3)),
        rate=100,
        sites=("left wrist", "sternum", "Füßchen"),
        activity="walk",
        subject="p1",
        clip="clip 1",
    )


def assert_same(read: ImuRecording, written: ImuRecording, labels: bool = True) -> None:
    np.testing.assert_array_equal(read.acc, written.acc)
    np.testing.assert_array_equal(read.gyr, written.gyr)
    assert read.rate == written.rate
    if labels:
        for name in ("sites", "activity", "subject", "clip"):
            assert getattr(read, name) == getattr(written, name)


@pytest.mark.later
@given(recordings())
@REUSE_FOLDER
def test_npz_round_trip(tmp_path, recording):
    path = tmp_path / "r.npz"
    recording.save(path)
    assert_same(ImuRecording.load(path), recording)


def test_equal_recordings_give_equal_bytes(tmp_path, walk):
    walk.save(tmp_path / "a.npz")
    ImuRecording.load(tmp_path / "a.npz").save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("content", [b"", b"not an archive", b"PK\x03\x04broken"])
def test_files_that_are_no_recording_are_named(tmp_path, content):
    path = tmp_path / "bad.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"bad\.npz is not a W2W recording"):
        ImuRecording.load(path)


def test_archives_of_something_else_are_named(tmp_path):
    np.savez(tmp_path / "other.npz", acc=np.zeros((3, 1, 3)))
    with pytest.raises(ValueError, match="lacks gyr, rate"):
        ImuRecording.load(tmp_path / "other.npz")
    np.savez(tmp_path / "pickled.npz", acc=np.array([{}]), gyr=np.zeros(1), rate=np.array(1.0))
    with pytest.raises(ValueError, match="pickle"):
        ImuRecording.load(tmp_path / "pickled.npz")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"acc": np.zeros((5, 3))}, r"acc must have shape \(T, N, 3\), not \(5, 3\)"),
        ({"acc": np.zeros((0, 2, 3)), "gyr": np.zeros((0, 2, 3))}, "acc must have shape"),
        ({"gyr": np.zeros((4, 2, 3))}, "gyr must have the shape of acc"),
        ({"acc": np.full((5, 2, 3), np.inf)}, "infinite"),
        ({"rate": 0}, "rate must be positive"),
        ({"rate": float("nan")}, "rate must be positive"),
        ({"sites": ("a",)}, "sites must name all 2 sensors or none, not 1"),
    ],
)
def test_recordings_are_checked(change, message):
    with pytest.raises(ValueError, match=message):
        ImuRecording(**{"acc": np.zeros((5, 2, 3)), "gyr": np.zeros((5, 2, 3)), "rate": 50, **change})


@pytest.mark.later
@given(
    recording=recordings(),
    acc_unit=st.sampled_from(["m/s2", "g"]),
    gyr_unit=st.sampled_from(["rad/s", "deg/s"]),
)
@REUSE_FOLDER
def test_csv_round_trip_loses_nothing(tmp_path, recording, acc_unit, gyr_unit):
    path = tmp_path / "r.csv"
    formats.write_csv(path, recording, acc_unit=acc_unit, gyr_unit=gyr_unit)
    assert_same(formats.read_csv(path), recording)


def test_csv_is_what_pandas_users_expect(tmp_path, walk):
    pandas = pytest.importorskip("pandas")
    formats.write_csv(tmp_path / "r.csv", walk, sensor=1, acc_unit="g", gyr_unit="deg/s")
    frame = pandas.read_csv(tmp_path / "r.csv", comment="#")
    assert list(frame.columns) == ["time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    np.testing.assert_allclose(frame["acc_y"] * 9.80665, walk.acc[:, 1, 1], rtol=1e-6)
    np.testing.assert_allclose(np.radians(frame["gyr_z"]), walk.gyr[:, 1, 2], rtol=1e-6)
    np.testing.assert_allclose(frame["time_s"], np.arange(200) / 100)


def test_foreign_csv_needs_units_and_regular_time(tmp_path):
    path = tmp_path / "foreign.csv"
    rows = [f"{k / 50:.3f},{k},0,1,{10 * k},0,0,extra" for k in range(5)]
    head = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,note"
    path.write_text("\n".join([head, *rows]).replace("extra", "7"))
    with pytest.raises(ValueError, match="does not name its units"):
        formats.read_csv(path)
    head = f"# acc_unit: g\n# gyr_unit: deg/s\n{head}"
    path.write_text("\n".join([head, *rows]).replace("extra", "7"))
    recording = formats.read_csv(path)
    assert recording.rate == 50
    assert recording.acc[2, 0, 0] == pytest.approx(2 * 9.80665)
    assert recording.gyr[3, 0, 0] == pytest.approx(np.radians(30))
    path.write_text("\n".join([head, *rows]))
    with pytest.raises(ValueError, match=r"foreign\.csv has a field that is no number"):
        formats.read_csv(path)
    path.write_text("\n".join([head, rows[0], rows[1], rows[4]]).replace("extra", "7"))
    with pytest.raises(ValueError, match="irregular time stamps"):
        formats.read_csv(path)
    path.write_text("time,ax\n0,1\n")
    with pytest.raises(ValueError, match="lacks the columns time_s, acc_x"):
        formats.read_csv(path)
    with pytest.raises(ValueError, match="acc_unit must be one of m/s2, g, not 'mg'"):
        formats.write_csv(path, _still(), acc_unit="mg")


@given(recording=recordings(), with_orientation=st.booleans())
@REUSE_FOLDER
def test_xsens_round_trip(tmp_path, recording, with_orientation):
    path = tmp_path / "r.txt"
    turns = Rotation.random(recording.n_samples, random_state=1).as_quat() if with_orientation else None
    vendor_formats.write_xsens_txt(path, recording, quaternions=turns)
    read = vendor_formats.read_xsens_txt(path)
    assert_same(read, recording, labels=False)
    assert (read.orientation is None) is not with_orientation
    if with_orientation:
        np.testing.assert_array_equal(read.orientation[:, 0], turns.astype(np.float32))


@pytest.mark.later
@given(recordings())
@REUSE_FOLDER
def test_x_io_round_trip(tmp_path, recording):
    vendor_formats.write_x_io(tmp_path / "device", recording)
    read = vendor_formats.read_x_io(tmp_path / "device")
    np.testing.assert_array_equal(read.acc, recording.acc)
    np.testing.assert_array_equal(read.gyr, recording.gyr)
    assert read.rate == pytest.approx(recording.rate, rel=2e-6 * recording.rate)


def test_sto_round_trip(tmp_path):
    turns = Rotation.random(60, random_state=3).as_quat().reshape(20, 3, 4)
    sites = ("pelvis_imu", "femur_r_imu", "left wrist")
    vendor_formats.write_orientation_sto(tmp_path / "o.sto", turns, 60.0, sites)
    read, rate, names = read_orientation_sto(tmp_path / "o.sto")
    np.testing.assert_array_equal(read, turns)
    assert (rate, names) == (60.0, sites)


def test_broken_text_files_are_named(tmp_path, walk):
    path = tmp_path / "file"
    path.write_text("PacketCounter\tAcc_X\n")
    with pytest.raises(ValueError, match="no MT Manager export"):
        vendor_formats.read_xsens_txt(path)
    path.write_text("// Update Rate: 100.0Hz\nPacketCounter\tAcc_X\n0\t1\n")
    with pytest.raises(ValueError, match="lacks the columns Acc_Y, Acc_Z, Gyr_X"):
        vendor_formats.read_xsens_txt(path)
    vendor_formats.write_xsens_txt(path, walk)
    path.write_text(path.read_text()[:-30])
    with pytest.raises(ValueError, match="row 200 has"):
        vendor_formats.read_xsens_txt(path)
    with pytest.raises(ValueError, match=r"no Inertial\.csv"):
        vendor_formats.read_x_io(tmp_path)


def test_opensim_reads_orientations_and_xsens_text(tmp_path, walk):
    opensim = pytest.importorskip("opensim")
    turns = Rotation.random(400, random_state=3).as_quat().reshape(200, 2, 4)
    vendor_formats.write_orientation_sto(tmp_path / "o.sto", turns, 100.0, ("pelvis_imu", "torso_imu"))
    table = opensim.TimeSeriesTableQuaternion(str(tmp_path / "o.sto"))
    assert list(table.getColumnLabels()) == ["pelvis_imu", "torso_imu"]
    read = np.array(
        [[table.getRowAtIndex(t).getElt(0, k).get(c) for c in range(4)] for t in (0, 199) for k in range(2)]
    )
    np.testing.assert_allclose(np.abs(read), np.abs(turns[[0, 199]].reshape(4, 4)), atol=1e-9)

    vendor_formats.write_xsens_txt(tmp_path / "MT_01.txt", walk, 0, turns[:, 0])
    settings_file = tmp_path / "s.xml"
    settings_file.write_text(
        '<?xml version="1.0"?><OpenSimDocument Version="40000"><XsensDataReaderSettings name="s">'
        "<trial_prefix>MT</trial_prefix><ExperimentalSensors>"
        '<ExperimentalSensor name="_01"><name_in_model>pelvis_imu</name_in_model></ExperimentalSensor>'
        "</ExperimentalSensors></XsensDataReaderSettings></OpenSimDocument>"
    )
    reader = opensim.XsensDataReader(opensim.XsensDataReaderSettings(str(settings_file)))
    tables = reader.read(f"{tmp_path}/")
    for found, written in (
        (reader.getLinearAccelerationsTable(tables), walk.acc),
        (reader.getAngularVelocityTable(tables), walk.gyr),
    ):
        assert found.getNumRows() == 200
        row = found.getRowAtIndex(57).getElt(0, 0)
        np.testing.assert_allclose([row.get(k) for k in range(3)], written[57, 0], rtol=1e-6)
        assert found.getIndependentColumn()[57] == pytest.approx(0.57)


def test_x_io_reads_its_own_format(tmp_path, walk):
    ximu3csv = pytest.importorskip("ximu3csv")
    vendor_formats.write_x_io(tmp_path / "log" / "device", walk, sensor=2)
    (device,) = ximu3csv.read(tmp_path / "log")
    np.testing.assert_allclose(device.inertial.accelerometer.xyz * 9.80665, walk.acc[:, 2], rtol=1e-6)
    np.testing.assert_allclose(np.radians(device.inertial.gyroscope.xyz), walk.gyr[:, 2], rtol=1e-6)
    np.testing.assert_array_equal(device.inertial.timestamp, np.arange(200) * 10_000)


def test_gaitmap_takes_the_csv_as_sensor_data(tmp_path, walk):
    helper = pytest.importorskip("gaitmap.utils.datatype_helper")
    pandas = pytest.importorskip("pandas")
    formats.write_csv(tmp_path / "foot.csv", walk, acc_unit="m/s2", gyr_unit="deg/s")
    frame = pandas.read_csv(tmp_path / "foot.csv", comment="#").set_index("time_s")
    assert helper.is_single_sensor_data(frame, frame="sensor", raise_exception=True)


def test_broad_comes_in_as_it_is(shared_data):
    pytest.importorskip("h5py")
    trial = read_broad(shared_data / "imu" / "broad" / "07_undisturbed_fast_rotation_B.hdf5")
    assert trial.recording.rate == pytest.approx(2000 / 7)
    assert trial.matrices.shape == (trial.recording.n_samples, 1, 4, 4)
    valid = np.isfinite(trial.matrices).all(axis=(1, 2, 3))
    rest = np.flatnonzero(valid & ~trial.movement)[:500]
    up = np.einsum("tij,tj->ti", trial.matrices[rest, 0, :3, :3], trial.recording.acc[rest, 0])
    np.testing.assert_allclose(up.mean(axis=0), [0, 0, 9.81], atol=0.1)


def test_gait_comes_in_as_it_is(shared_data):
    trial = read_gait(shared_data / "imu" / "gait", GAIT_TRIAL)
    assert trial.recording.acc.shape == (955, 9, 3)
    assert trial.recording.rate == 100
    assert trial.first_row == 1119
    assert trial.vicon["PELV"].shape == (955, 3)
    assert trial.vicon["qRFT"].shape == (955, 4)
    for sensor in range(9):
        turn = Rotation.from_quat(trial.orientations[:, sensor, [1, 2, 3, 0]])
        np.testing.assert_allclose(
            turn.apply(trial.recording.acc[:, sensor]).mean(axis=0), [0, 0, 9.81], atol=0.25
        )
        spin = (turn[:-2].inv() * turn[2:]).as_rotvec() * 50
        assert np.corrcoef(spin.ravel(), trial.recording.gyr[1:-1, sensor].ravel())[0, 1] > 0.97


@pytest.mark.later
def test_dsads_comes_in_as_it_is(shared_data):
    windows = read_dsads(shared_data / "imu" / "dsads" / "dsads_acc_gyr_25hz.npz")
    assert len(windows) == 3040
    assert windows[0].sites == DSADS_SITES
    assert windows[0].acc.shape == (125, 5, 3)
    assert {w.activity for w in windows} >= {"sitting", "rowing", "playing basketball"}
    assert len({w.activity for w in windows}) == 19
    sitting = np.concatenate([w.acc for w in windows if w.activity == "sitting"])
    assert np.median(np.linalg.norm(sitting, axis=-1)) == pytest.approx(9.81, abs=0.4)


def test_utd_mhad_comes_in_as_it_is(shared_data):
    trials = read_utd_mhad(shared_data / "imu" / "utd_mhad" / "utd_mhad_subjects_1_4.npz")
    assert len(trials) == 431
    by_clip = {trial.recording.clip: trial for trial in trials}
    walk = by_clip["a23_s1_t1"]
    assert walk.recording.sites == ("right thigh",)
    assert walk.recording.activity == "walk"
    assert by_clip["a3_s1_t1"].recording.sites == ("right wrist",)
    assert walk.skeleton.shape[1:] == (20, 3)
    seconds = [len(t.skeleton) / 30 - t.recording.n_samples / 50 for t in trials]
    assert np.abs(np.median(seconds)) < 1.5
    assert np.median(np.linalg.norm(walk.recording.acc, axis=-1)) == pytest.approx(9.81, abs=1.5)


@pytest.mark.parametrize("reader", [read_dsads, read_utd_mhad])
def test_archives_of_another_set_are_refused(tmp_path, reader):
    np.savez(tmp_path / "other.npz", y=np.zeros(3))
    with pytest.raises(ValueError, match=r"other\.npz is no (DSADS|UTD-MHAD) archive"):
        reader(tmp_path / "other.npz")


def test_missing_and_damaged_gait_files_are_named(tmp_path):
    with pytest.raises(ValueError, match=r"holds no files T-<site>\.csv"):
        read_gait(tmp_path, "T")
    (tmp_path / "T-foot.csv").write_text("acc_1,acc_2\n1,2\n")
    with pytest.raises(ValueError, match=r"T-foot\.csv is no gaittoolbox file"):
        read_gait(tmp_path, "T")


def test_broad_says_what_a_file_lacks(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "trial.hdf5"
    path.write_bytes(b"nothing")
    with pytest.raises(ValueError, match="no HDF5 file that can be opened"):
        read_broad(path)
    with h5py.File(path, "w") as data:
        data["imu_acc"] = np.zeros((3, 3))
    with pytest.raises(ValueError, match="lacks imu_gyr, opt_pos"):
        read_broad(path)


def _still() -> ImuRecording:
    return ImuRecording(acc=np.zeros((3, 1, 3)), gyr=np.zeros((3, 1, 3)), rate=50)


def test_text_of_characters_that_do_not_exist_is_refused(tmp_path):
    sites = np.frombuffer(np.array([0x110000, 65], dtype="<u4").tobytes(), dtype="<U2")
    np.savez(tmp_path / "odd.npz", acc=np.zeros((2, 1, 3)), gyr=np.zeros((2, 1, 3)), rate=1.0, sites=sites)
    with pytest.raises(
        ValueError, match=r"odd\.npz is not a W2W recording: its 'sites' is damaged or holds neither"
    ):
        ImuRecording.load(tmp_path / "odd.npz")


@pytest.mark.parametrize(
    ("name", "kind"), [("a.npz", ""), ("a.csv", ""), ("a.txt", ""), ("log", ""), ("b", "csv")]
)
def test_a_recording_comes_back_from_every_format(tmp_path, name, kind):
    rng = np.random.default_rng(4)
    written = ImuRecording(rng.normal(size=(40, 1, 3)), rng.normal(size=(40, 1, 3)), 50.0, ("wrist",))
    formats.write_recording(tmp_path / name, written, kind)
    again = formats.read_recording(tmp_path / name, kind)
    assert again.rate == pytest.approx(50.0)
    exact = {} if name != "log" else {"rtol": 1e-6, "atol": 1e-9}  # g and deg/s are other numbers
    for values, expected in ((again.acc, written.acc), (again.gyr, written.gyr)):
        np.testing.assert_allclose(values, expected, **(exact or {"rtol": 0, "atol": 0}))


def test_a_format_that_is_none_is_said(tmp_path):
    recording = _still()
    for name, kind, sentence in (
        ("a.csv", "mvnx", "no format is called 'mvnx'"),
        ("a.doc", "", r"\.doc stands for no"),
    ):
        with pytest.raises(ValueError, match=sentence):
            formats.write_recording(tmp_path / name, recording, kind)
        with pytest.raises(ValueError, match=sentence):
            formats.read_recording(tmp_path / name, kind)
    assert not list(tmp_path.iterdir())
