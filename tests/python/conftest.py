"""What the tests share: the tool, a simulated log with its truth, and maps built from it by the tool."""

import os
import subprocess

import numpy as np
import pytest

import lamap

CLASSES = [lamap.BGKMap, lamap.GPMap, lamap.HilbertMap, lamap.OverlappingHilbertMap]


def run_tool(*arguments):
    """Runs `lamap` and returns what it prints."""
    return subprocess.run(
        [os.environ["LAMAP_PROGRAM"], *map(str, arguments)], check=True, capture_output=True, text=True
    ).stdout


@pytest.fixture
def tool():
    return run_tool


@pytest.fixture(scope="session")
def world(tmp_path_factory):
    """A folder with log.rawlog and truth.csv."""
    folder = tmp_path_factory.mktemp("world")
    run_tool("simulate", "structured", "--scans", "2", "--seed", "3", "-o", folder / "log.rawlog",
             "--truth", folder / "truth.csv")  # fmt: skip
    return folder


@pytest.fixture(scope="session", params=CLASSES, ids=lambda kind: kind.__name__)
def kind(request):
    """Each class of maps."""
    return request.param


@pytest.fixture(scope="session")
def built(world, kind):
    """The file of a map that the tool built from the log."""
    path = world / (kind.alias + ".lamap.gz")
    run_tool("build", "-i", world / "log.rawlog", "-m", kind.alias, "-s", "creationOpts.resolution=0.2",
             "-s", "insertOpts.maxRange=8", "-o", path)  # fmt: skip
    return path


def circle(radius=3.0, count=200):
    """Points on a wall around the origin, (count, 3)."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(count)])


@pytest.fixture
def wall():
    return circle()
