"""What maps learn and answer."""

import concurrent.futures
import copy
import csv
import io
import pickle
import threading

import numpy as np
import pytest

import lamap
from lamap import State


def pose_matrix(x, y, z, yaw):
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.array([[cosine, -sine, 0, x], [sine, cosine, 0, y], [0, 0, 1, z], [0, 0, 0, 1]])


def test_a_wall_is_occupied_and_the_space_before_it_free(kind, wall):
    map = kind()
    assert map.is_empty and map.bounds is None
    assert map.insert(wall)
    answer = map.query([[3, 0, 0], [1.5, 0, 0], [40, 0, 0]])
    assert list(answer.state) == [State.OCCUPIED, State.FREE, State.UNOBSERVED]
    assert answer.prob[0] > 0.7 and answer.prob[1] < 0.3 and np.isnan(answer.prob[2])
    assert answer.state.dtype == np.int8
    assert not map.is_empty
    assert (map.bounds[0] <= -3).sum() == 2 and (map.bounds[1] >= 3).sum() == 2


def test_query_answers_as_the_tool(kind, built, tool):
    map = kind.load(built)
    low, high = map.bounds
    points = np.random.default_rng(1).uniform(low - 1, high + 1, (500, 3)).round(6)
    name = built.with_suffix(".points.csv")
    np.savetxt(name, points, fmt="%.6f", delimiter=",")
    answer = map.query(points)
    rows = list(csv.DictReader(io.StringIO(tool("query", built, "--points", name))))
    assert len(rows) == 500
    for i, row in enumerate(rows):
        assert State[row["state"].upper()] == answer.state[i]
        assert row["prob"] == "" or float(row["prob"]) == answer.prob[i]
        assert row["variance"] == "" or float(row["variance"]) == answer.variance[i]
    assert {row["state"] for row in rows} >= {"free", "unobserved"}
    for threads in (1, 2):
        map.threads = threads
        np.testing.assert_array_equal(np.tile(answer.prob, 40), map.query(np.tile(points, (40, 1))).prob)


def test_places_that_no_cell_has_are_unobserved(kind, wall):
    map = kind()
    map.insert(wall)
    answer = map.query([[np.nan, 0, 0], [0, np.inf, 0], [1e300, 0, 0], [3, 0, 0]])
    assert list(answer.state) == [State.UNOBSERVED] * 3 + [State.OCCUPIED]


def test_one_point_gives_numbers(wall):
    map = lamap.BGKMap()
    map.insert(wall)
    answer = map.query([3, 0, 0])
    assert answer.prob.shape == () and answer.state == State.OCCUPIED


def test_cells_are_those_that_the_tool_exports(kind, built, tool, tmp_path):
    tool("export", built, "-o", tmp_path / "cells.csv")
    with open(tmp_path / "cells.csv") as file:
        head = file.readline().strip().split(",")
        rows = [line.strip().split(",") for line in file]
    map = kind.load(built)
    cells = map.cells()
    assert cells.size == map.resolution == 0.2
    assert tuple(head[6:]) == map.evidence_names
    np.testing.assert_allclose(cells.centre, np.array([row[:3] for row in rows], float), atol=1e-8)
    np.testing.assert_allclose(cells.prob, np.array([row[3] for row in rows], float), rtol=1e-8)
    assert [State(state).name.lower() for state in cells.state] == [row[5] for row in rows]
    np.testing.assert_allclose(cells.evidence, np.array([row[6:] for row in rows], float), rtol=1e-7)


def test_origin_and_pose_are_two_ways_to_say_the_same(kind, wall):
    by_origin, by_pose, by_angles = kind(), kind(), kind()
    assert by_origin.insert(wall + [1, 2, 0.5], origin=[1, 2, 0.5])
    assert by_pose.insert(wall, pose=pose_matrix(1, 2, 0.5, 0))
    assert by_angles.insert(wall, pose=[1, 2, 0.5, 0, 0, 0])
    assert by_pose == by_angles
    probes = wall * 0.9 + [1, 2, 0.5]
    # A point on the face of two cells may be rounded into either.
    assert np.abs(by_origin.query(probes).prob - by_pose.query(probes).prob).mean() < 0.01


def test_a_pose_turns_the_points(wall):
    ahead = wall[:5] * [1, 1, 0]
    turned = lamap.BGKMap()
    turned.insert(ahead, pose=pose_matrix(0, 0, 0, np.pi / 2))
    by_angles = lamap.BGKMap()
    by_angles.insert(ahead, pose=[0, 0, 0, np.pi / 2, 0, 0])
    for map in (turned, by_angles):
        assert map.query([0, 3, 0]).state == State.OCCUPIED
        assert map.query([3, 0, 0]).state == State.UNOBSERVED


@pytest.mark.parametrize("frame", [{"origin": [5, 0, 0]}, {"pose": [5, 0, 0, 0, 0, 0]}])
def test_an_uncertain_pose_blurs_the_map_alike_in_both_frames(wall, frame):
    covariance = np.diag([0.04, 0.04, 1e-6, 0.01, 1e-8, 1e-8])
    sharp, blurred = (lamap.BGKMap(usePoseCovariance=True) for _ in range(2))
    points = wall + [5, 0, 0] if "origin" in frame else wall
    sharp.insert(points, **frame)
    blurred.insert(points, covariance=covariance, **frame)
    at_wall = wall + [5, 0, 0]
    assert blurred.query(at_wall).prob.mean() < sharp.query(at_wall).prob.mean() - 0.01
    # The rotation is about the sensor, not about the origin of the map: all sides of the wall are alike.
    sides = blurred.query(at_wall).prob.reshape(4, -1).mean(axis=1)
    assert np.ptp(sides) < 0.05


def test_rays_without_a_return_are_free_up_to_the_range(wall):
    map = lamap.BGKMap()
    assert map.insert(wall[:50], returned=np.zeros(50, bool), max_range=2.0)
    assert map.ray_counts["no_return"] == 50 and map.ray_counts["hits"] == 0
    assert map.query([1, 0.5, 0]).state == State.FREE
    assert map.query(wall[:1]).state[0] == State.UNOBSERVED
    with_origin = lamap.BGKMap()
    with_origin.insert(wall[:50] + 9, origin=[9, 9, 9], returned=np.zeros(50, bool), max_range=2.0)
    assert with_origin.query([10, 9.5, 9]).state == State.FREE


def test_rays_without_a_return_need_a_range(wall):
    map = lamap.BGKMap()
    assert not map.insert(wall, returned=np.zeros(len(wall), bool))
    assert map.ray_counts["unbounded"] == len(wall) and map.is_empty


def test_stated_ranges_and_beams_count(wall):
    map = lamap.BGKMap()
    map.insert(wall, min_range=4)
    assert map.ray_counts["too_near"] == len(wall)
    narrow, wide = lamap.BGKMap(beamWidth="observation"), lamap.BGKMap(beamWidth="observation")
    narrow.insert(wall[:1])
    wide.insert(wall[:1], beam_width=0.5)
    assert wide.cells().prob.size > 2 * narrow.cells().prob.size
    blurred = lamap.BGKMap(beamWidth="observation")
    blurred.insert(wall, range_std=0.3)
    assert blurred.query(wall).prob.mean() != narrow.query(wall).prob.mean()


def test_points_that_are_not_finite_are_counted_and_told_once(kind, wall, caplog, capfd):
    map, clean = kind(), kind()
    spoilt = np.vstack([wall, [[np.nan, 0, 0], [np.inf, 1, 1]]])
    map.insert(spoilt)
    map.insert(spoilt)
    clean.insert(wall)
    clean.insert(wall)
    assert map.ray_counts["not_finite"] == 4
    assert map == clean
    assert [record.levelname for record in caplog.records if "NaN" in record.message] == ["WARNING"]
    assert capfd.readouterr() == ("", "")  # MRPT would print it


def test_cast_rays(wall):
    map = lamap.BGKMap()
    map.insert(wall)
    rays = map.cast_rays([0, 0, 0], wall)
    assert rays.hit.dtype == bool and rays.hit.all()
    assert np.abs(np.linalg.norm(rays.end, axis=1) - 3).max() < 0.3
    assert not map.cast_rays([0, 0, 0], wall, 2.0).hit.any()
    assert not map.cast_rays([0, 0, 0], [0, 0, 1]).hit
    one = map.cast_rays(np.zeros((2, 3)), [1, 0, 0])
    assert one.hit.shape == (2,) and one.end.shape == (2, 3)
    through_unknown = map.cast_rays([20, 0, 0], [-1, 0, 0], ignore_unknown=True)
    assert through_unknown.hit and not map.cast_rays([20, 0, 0], [-1, 0, 0]).hit
    assert np.isnan(map.cast_rays([np.nan, 0, 0], [1, 0, 0]).end).all()


def test_log_likelihood_is_highest_where_the_scan_was_taken(kind, wall):
    square = np.abs(wall).max(axis=1, keepdims=True)
    room = wall / square * 3
    map = kind()
    for _ in range(3):
        map.insert(room)
    poses = np.array([[0, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0], [0, 0, 0, 0.4, 0, 0]])
    logs = map.log_likelihood(room, poses)
    assert logs.shape == (3,) and logs.argmax() == 0
    matrices = np.stack([pose_matrix(*poses[i][:4]) for i in range(3)])
    np.testing.assert_allclose(map.log_likelihood(room, matrices), logs, rtol=1e-6)
    assert map.log_likelihood(room, poses[0]).shape == ()


@pytest.mark.parametrize("kind", [lamap.BGKMap, lamap.GPMap, lamap.OverlappingHilbertMap])
def test_merging_is_inserting_both(kind, wall):
    a, b, both = kind(), kind(), kind()
    for map in (a, both):
        map.insert(wall)
    for map in (b, both):
        map.insert(wall + [1, 0, 0], origin=[1, 0, 0])
    before = copy.copy(b)
    a.merge(b)
    assert b == before
    np.testing.assert_allclose(a.query(wall).prob, both.query(wall).prob, atol=1e-6)
    if kind is lamap.BGKMap:
        assert a.cells().evidence.tobytes() == both.cells().evidence.tobytes()
    b.merge(b)
    before.merge(copy.copy(before))
    assert b == before


def test_only_the_same_kind_and_cells_can_be_merged():
    with pytest.raises(ValueError, match="resolution"):
        lamap.BGKMap().merge(lamap.BGKMap(resolution=0.2))
    with pytest.raises(TypeError):
        lamap.BGKMap().merge(lamap.GPMap())
    assert not hasattr(lamap.HilbertMap, "merge")


def test_pickles_and_copies_are_equal_and_independent(kind, wall):
    map = kind(resolution=0.2, maxRange=9)
    map.insert(wall)
    pickled = [pickle.loads(pickle.dumps(map, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)]
    for twin in (*pickled, copy.copy(map), copy.deepcopy(map)):
        assert type(twin) is kind
        assert twin == map and not twin != map
        assert dict(twin.options) == dict(map.options)
        twin.insert(wall * 1.1)
        assert twin != map
    assert map != kind(resolution=0.2, maxRange=9)
    assert map != "map"
    with pytest.raises(TypeError):
        hash(map)
    assert pickle.loads(pickle.dumps(map.query(wall))).prob.shape == (len(wall),)


def test_an_object_whose_init_was_not_called_is_refused():
    unmade = lamap.BGKMap.__new__(lamap.BGKMap)
    for use in (repr, lambda map: map.query([[0, 0, 0]]), copy.copy, pickle.dumps):
        with pytest.raises(TypeError, match="__init__ of this map was not called"):
            use(unmade)


def test_a_change_does_not_wait_for_those_who_read_later(wall):
    map = lamap.BGKMap(resolution=0.05)
    map.insert(wall, origin=(0, 0, 0))
    places = np.tile(wall, (50, 1))
    changed = threading.Event()

    def read():
        for _ in range(1000):  # readers end after the change, or after all of these
            if changed.is_set():
                return True
            map.query(places)
        return False

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        readers = [pool.submit(read) for _ in range(4)]
        for _ in range(5):
            map.insert(wall, origin=(0, 0, 0))
        changed.set()
        assert all(reader.result() for reader in readers)


def test_a_pickle_that_is_cut_short_or_of_another_class_is_refused(wall):
    map = lamap.BGKMap()
    map.insert(wall)
    state = map.__getstate__()
    for spoilt in (b"", state[:10], state[:-9], state[: len(state) // 2], b"\0" * 40):
        with pytest.raises(ValueError):
            lamap.BGKMap.__new__(lamap.BGKMap).__setstate__(spoilt)
    with pytest.raises(ValueError, match="another class"):
        lamap.GPMap.__new__(lamap.GPMap).__setstate__(state)


def test_models_can_be_moved(wall):
    map, rebuilt = lamap.OverlappingHilbertMap(), lamap.OverlappingHilbertMap()
    map.insert(wall, pose=[0, 0, 0, 0, 0, 0])
    rebuilt.insert(wall, pose=[1, 0, 0, 0.5, 0, 0])
    assert map.model_count == 1
    np.testing.assert_array_equal(map.model_pose(0), np.eye(4))
    map.set_model_pose(0, [1, 0, 0, 0.5, 0, 0])
    np.testing.assert_allclose(map.query(wall).prob, rebuilt.query(wall).prob, atol=1e-9)
    with pytest.raises(IndexError):
        map.model_pose(1)


def test_clearing_keeps_the_options(kind, wall):
    map = kind(resolution=0.3)
    map.insert(wall)
    map.clear()
    assert map.is_empty and map.resolution == 0.3 and map == kind(resolution=0.3)


def test_repr_and_str(kind, wall):
    map = kind()
    assert repr(map) == f"<lamap.{kind.__name__}: cells of 0.1 m, empty>"
    map.insert(wall)
    assert repr(map).startswith(f"<lamap.{kind.__name__}: cells of 0.1 m, from (-")
    assert "occupied cells" in str(map)


def test_threads_read_and_change_one_map(kind):
    scans = [np.random.default_rng(seed).normal(0, 3, (200, 3)) for seed in range(6)]
    shared, alone = kind(resolution=0.2, maxRange=8), kind(resolution=0.2, maxRange=8)
    shared.threads = 1
    stop = threading.Event()
    failures = []

    def ask():
        try:
            while not stop.is_set():
                answer = shared.query(scans[0])
                observed = answer.state != State.UNOBSERVED
                assert ((answer.prob[observed] >= 0) & (answer.prob[observed] <= 1)).all()
                shared.cast_rays([0, 0, 0], scans[1][:20])
                repr(shared)
                copy.copy(shared)
        except BaseException as error:  # noqa: BLE001: told to the main thread
            failures.append(error)

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    for scan in scans:
        shared.insert(scan)
        alone.insert(scan)
    stop.set()
    for thread in threads:
        thread.join()
    assert not failures
    assert shared == alone


def test_two_threads_can_merge_two_maps_into_each_other(wall):
    a, b = lamap.BGKMap(), lamap.BGKMap()
    a.insert(wall)
    b.insert(wall * 1.2)

    def merge(into, other):
        for _ in range(20):
            into.merge(other)
            other.merge(lamap.BGKMap())

    threads = [threading.Thread(target=merge, args=pair) for pair in ((a, b), (b, a))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
