"""Saving, loading, and files that are not what they should be."""

import os
import random

import pytest

import lamap


def test_saved_maps_are_those_of_the_tool_byte_for_byte(kind, built, tmp_path):
    map = lamap.load(built)
    assert type(map) is kind
    assert kind.load(os.fsencode(built)) == map
    map.save(tmp_path / "again.lamap.gz")
    assert (tmp_path / "again.lamap.gz").read_bytes() == built.read_bytes()


def test_the_tool_reads_what_python_saved(kind, wall, tmp_path, tool):
    map = kind()
    map.insert(wall)
    map.save(str(tmp_path / "map.lamap.gz"))
    assert ",occupied," in tool("query", tmp_path / "map.lamap.gz", "--at", "3,0,0")


def test_a_file_of_another_class(tmp_path):
    lamap.GPMap().save(tmp_path / "gp.lamap.gz")
    with pytest.raises(lamap.FileError, match="its map is a lamap::CGPMap, not a lamap::CBGKMap"):
        lamap.BGKMap.load(tmp_path / "gp.lamap.gz")


def test_another_librarys_map(tmp_path, world, tool):
    tool("build", "-i", world / "log.rawlog", "-m", "pointsMap", "-o", tmp_path / "points.lamap.gz")
    with pytest.raises(lamap.FileError, match="not one of this library's maps"):
        lamap.load(tmp_path / "points.lamap.gz")


def test_files_that_are_no_maps(tmp_path):
    (tmp_path / "empty").touch()
    (tmp_path / "text").write_text("no map")
    for name in ("empty", "text", "."):
        with pytest.raises(OSError) as caught:
            lamap.load(tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)
        assert caught.value.filename == str(tmp_path / name)
    with pytest.raises(FileNotFoundError, match="none"):
        lamap.load(tmp_path / "none")
    for name in (None, 3, "a\0b"):
        with pytest.raises((TypeError, ValueError)):
            lamap.load(name)


def test_a_name_that_is_not_utf8(tmp_path, wall):
    name = os.fsencode(tmp_path) + b"/\xff.lamap.gz"
    map = lamap.BGKMap()
    map.save(name)
    assert lamap.load(name) == map
    with pytest.raises(FileNotFoundError):
        lamap.load(name + b"x")


def test_damaged_files_are_refused(kind, built, tmp_path):
    good = built.read_bytes()
    generator = random.Random(1)
    path = tmp_path / "damaged.lamap.gz"
    refused = 0
    for i in range(60):
        damaged = bytearray(good)
        if i % 2:
            damaged = damaged[: generator.randrange(len(damaged))]
        else:
            damaged[generator.randrange(len(damaged))] ^= 1 << generator.randrange(8)
        path.write_bytes(damaged)
        try:
            lamap.load(path)
        except OSError as error:
            refused += 1
            assert error.filename == str(path)
    assert refused >= 55  # a few bits of a gzip's head mean nothing


def test_what_cannot_be_written(tmp_path):
    map = lamap.BGKMap()
    with pytest.raises(OSError, match="no-such-folder") as caught:
        map.save(tmp_path / "no-such-folder" / "map.lamap.gz")
    assert caught.value.filename == str(tmp_path / "no-such-folder" / "map.lamap.gz")
    with pytest.raises(OSError):
        map.save(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_errors_are_of_the_right_classes():
    assert issubclass(lamap.FileError, OSError)
    assert issubclass(lamap.MissingFileError, FileNotFoundError)
