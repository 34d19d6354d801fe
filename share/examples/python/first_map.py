"""A map from arrays: insert scans, ask, cast rays, save and load."""

import numpy as np

import lamap


def scan(radius, count=360):
    """A round wall about the sensor, seen by a planar laser: (count, 3) [m], in the frame of the sensor."""
    angle = np.linspace(-np.pi, np.pi, count, endpoint=False)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(count)])


for kind in (lamap.BGKMap, lamap.GPMap, lamap.HilbertMap, lamap.OverlappingHilbertMap):
    map = kind(resolution=0.1)
    map.insert(scan(3.0), pose=[0.5, 0, 0, 0, 0, 0])  # x, y, z, yaw, pitch, roll of the sensor in the map

    answer = map.query([[3.5, 0, 0], [1.5, 0, 0], [9, 0, 0]])
    for prob, state in zip(answer.prob, answer.state):
        print(f"{kind.__name__}: P(occupied) {prob:.3f}, {lamap.State(state).name.lower()}")

    rays = map.cast_rays([0.5, 0, 0], [[1, 0, 0], [0, 1, 0]])
    assert rays.hit.all()

    map.save(f"{map.alias}.lamap.gz")
    assert lamap.load(f"{map.alias}.lamap.gz") == map
