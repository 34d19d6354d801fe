"""Arrays of every layout and type, and what is refused."""

import gc
import resource
import sys
import weakref

import numpy as np
import pytest

import lamap


@pytest.fixture
def map(wall):
    map = lamap.BGKMap()
    map.insert(wall)
    return map


def layouts(points):
    """The same numbers in other places of memory."""
    rows, columns = points.shape
    wide = np.full((2 * rows, columns + 4), np.nan)
    wide[::2, 1 : columns + 1] = points
    unaligned = np.frombuffer(b"x" + points.tobytes(), np.uint8)[1:].view(np.float64).reshape(points.shape)
    yield wide[::2, 1 : columns + 1]
    yield np.asfortranarray(points)
    yield np.ascontiguousarray(points[::-1])[::-1]
    yield np.ascontiguousarray(points[:, ::-1])[:, ::-1]
    yield points.astype(">f8")
    yield points.astype(np.longdouble)
    yield unaligned
    yield points.tolist()
    read_only = points.copy()
    read_only.flags.writeable = False
    yield read_only


def test_the_layout_of_points_changes_nothing(map, wall):
    expected = map.query(wall)
    for points in layouts(wall):
        for a, b in zip(map.query(points), expected):
            np.testing.assert_array_equal(a, b)
        learned = lamap.BGKMap()
        learned.insert(points)
        assert learned == map


def test_float32_is_read_as_the_doubles_that_it_holds(map, wall):
    single = wall.astype(np.float32)
    expected = map.query(single.astype(np.float64))
    np.testing.assert_array_equal(map.query(single).prob, expected.prob)
    np.testing.assert_array_equal(map.query(np.asfortranarray(single)[::2]).prob, expected.prob[::2])


@pytest.mark.parametrize("dtype", [np.float16, np.int8, np.int64, np.uint32])
def test_other_numbers_are_converted(map, dtype):
    points = np.array([[3, 0, 0], [1, 1, 0]], dtype)
    np.testing.assert_array_equal(map.query(points).prob, map.query(points.astype(float)).prob)


def test_a_broadcast_point_is_read_with_strides_of_zero(map):
    answer = map.query(np.broadcast_to([3.0, 0.0, 0.0], (7, 3)))
    assert answer.prob.shape == (7,) and np.ptp(answer.prob) == 0 and answer.prob[0] > 0.5


def test_no_points_are_no_scan(map):
    before = map.cells().evidence
    assert not map.insert(np.empty((0, 3)))
    assert map.query(np.empty((0, 3))).prob.shape == (0,)
    np.testing.assert_array_equal(map.cells().evidence, before)


SHAPES = [np.zeros(4), np.zeros((5, 2)), np.zeros((3, 5)), np.zeros((2, 3, 3)), np.float64(1), []]


@pytest.mark.parametrize("points", SHAPES, ids=lambda points: str(np.shape(points)))
def test_wrong_shapes_are_named(map, points):
    shape = str(np.shape(points)).replace("(", r"\(").replace(")", r"\)")
    with pytest.raises(ValueError, match=r"points: must have the shape \(N, 3\), not " + shape):
        map.insert(points)
    with pytest.raises(ValueError, match="points: must have the shape"):
        map.query(points)
    with pytest.raises(ValueError, match="directions: must have the shape"):
        map.cast_rays([0, 0, 0], points)


@pytest.mark.parametrize(
    "points", [None, "abc", [["a", "b", "c"]], [[1j, 0, 0]], [[True, False, True]], {}, [[1, 2, 3], [1, 2]]]
)
@pytest.mark.filterwarnings("ignore::numpy.VisibleDeprecationWarning")
def test_what_is_no_array_of_numbers_is_refused(map, points):
    with pytest.raises((TypeError, ValueError), match="points: must be an array of numbers"):
        map.insert(points)


BAD_ARGUMENTS = [
    (dict(origin=[0, 0, 0], pose=np.eye(4)), "origin and pose"),
    (dict(origin=[0, 0]), "origin: must have the shape"),
    (dict(origin=[[0, 0, 0]]), "origin: must have the shape"),
    (dict(origin=[np.nan, 0, 0]), "origin: must be finite"),
    (dict(pose=np.eye(3)), r"pose: must be a \(4, 4\) matrix"),
    (dict(pose=np.ones((4, 4))), "pose: must be a rigid motion"),
    (dict(pose=np.diag([1, 1, -1, 1])), "pose: must be a rigid motion"),
    (dict(pose=np.eye(4) * 2), "pose: must be a rigid motion"),
    (dict(pose=np.full(6, np.inf)), "pose: must be finite"),
    (dict(pose=np.zeros((2, 6))), "pose: must be one pose"),
    (dict(covariance=np.eye(3)), r"covariance: must have the shape \(6, 6\)"),
    (dict(covariance=-np.eye(6)), "covariance: must be finite and symmetric"),
    (dict(covariance=np.triu(np.ones((6, 6)))), "covariance: must be finite and symmetric"),
    (dict(covariance=np.full((6, 6), np.nan)), "covariance: must be finite and symmetric"),
    (dict(returned=np.zeros(3, bool)), r"returned: must have the shape \(200,\)"),
    (dict(max_range=-1), "max_range: must be >= 0"),
    (dict(min_range=np.nan), "max_range: must be >= 0"),
    (dict(beam_width=-1), "beam_width"),
    (dict(range_std=np.inf), "range_std"),
]


@pytest.mark.parametrize("arguments,message", BAD_ARGUMENTS, ids=[str(i) for i in range(len(BAD_ARGUMENTS))])
def test_bad_arguments_change_nothing(wall, arguments, message):
    map = lamap.BGKMap()
    with pytest.raises(ValueError, match=message):
        map.insert(wall, **arguments)
    assert map.is_empty


def test_a_mask_of_another_type_is_refused(map, wall):
    with pytest.raises(TypeError, match="returned: must be an array of bool"):
        map.insert(wall, returned=np.ones(len(wall)))


def test_as_many_origins_as_directions(map):
    with pytest.raises(ValueError, match="as many as origins, 2, not 3"):
        map.cast_rays(np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(ValueError, match="max_range: must be > 0"):
        map.cast_rays([0, 0, 0], [1, 0, 0], 0)


def test_no_reference_leaks(map, wall):
    pose, mask = np.eye(4), np.ones(len(wall), bool)
    counted = (map, wall, pose, mask)

    def use():
        map.insert(wall, pose=pose, returned=mask)
        map.query(wall)
        map.cast_rays(wall, wall)
        map.log_likelihood(wall, pose)
        map.options, map.bounds, map.ray_counts, map.report
        with pytest.raises(ValueError):
            map.insert(wall, pose=np.zeros((4, 4)))

    use()
    gc.collect()
    before = [sys.getrefcount(one) for one in counted]
    for _ in range(10):
        use()
    gc.collect()
    assert [sys.getrefcount(one) for one in counted] == before


def test_results_are_freed(map):
    prob = weakref.ref(map.query(np.zeros((10, 3))).prob)
    assert prob() is None
    points = np.zeros((500_000, 3))
    for _ in range(3):
        map.query(points)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(10):  # 8.5 MB each
        map.query(points)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 40_000  # KiB


def test_maps_are_freed():
    map = lamap.BGKMap()
    freed = []
    weakref.finalize(map, freed.append, True)
    del map
    assert freed == [True]


def test_a_rotation_that_was_rounded_is_made_one_again(wall):
    turn = np.eye(4)
    angle = 0.3
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    exact, rounded = lamap.BGKMap(), lamap.BGKMap()
    exact.insert(wall, pose=turn)
    rounded.insert(wall, pose=np.round(turn, 4))
    here, there = exact.query(wall), rounded.query(wall)
    assert np.allclose(here.prob, there.prob, atol=0.05, equal_nan=True)
    single = np.eye(4, dtype=np.float32)
    for _ in range(300):
        single = single @ turn.astype(np.float32)
    lamap.BGKMap().insert(wall, pose=single)
    with pytest.raises(ValueError, match="may be off by 0.001, not by 0.0"):
        exact.insert(wall, pose=np.round(turn, 1))
