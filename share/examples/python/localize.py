"""Where is the sensor? The likelihood of scans at many poses, as a particle filter asks for it."""

import numpy as np

import lamap

rng = np.random.default_rng(1)


def ranges_to_room(x, y, yaw, count=180):
    """What a laser sees of a room of 8 m by 5 m, in its own frame: (count, 3) [m]."""
    angle = np.linspace(-np.pi, np.pi, count, endpoint=False) + yaw
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    with np.errstate(divide="ignore"):
        to_walls = np.abs((np.sign(direction) * [4, 2.5] - [x, y]) / direction)
    distance = to_walls.min(axis=1) + rng.normal(0, 0.02, count)
    return np.column_stack([distance * np.cos(angle - yaw), distance * np.sin(angle - yaw), np.zeros(count)])


map = lamap.BGKMap(planar=True)
for x in np.linspace(-3, 3, 7):
    map.insert(ranges_to_room(x, 0.5, 0), pose=[x, 0.5, 0, 0, 0, 0])

true_pose = np.array([1.2, -0.8, 0.3])

# Particles around a guess that is half a metre off.
particles = np.zeros((2000, 6))  # x, y, z, yaw, pitch, roll
particles[:, [0, 1, 3]] = true_pose + [0.4, -0.3, 0.1] + rng.normal(0, [0.4, 0.4, 0.15], (2000, 3))
logs = sum(map.log_likelihood(ranges_to_room(*true_pose), particles) for _ in range(20))
weights = np.exp(logs - logs.max())
found = weights @ particles[:, [0, 1, 3]] / weights.sum()
print("true", true_pose, "found", found.round(2))
assert np.abs(found - true_pose).max() < 0.15
