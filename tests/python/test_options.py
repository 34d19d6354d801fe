"""Options as keywords."""

import pathlib

import numpy as np
import pytest

import lamap


def test_every_option_is_a_keyword_and_comes_back(kind):
    defaults = kind().options
    assert len(defaults) > 30
    given = {key: value for key, value in defaults.items() if value is not None}
    again = kind(**given)
    assert dict(again.options) == dict(defaults)
    assert again == kind()


def test_options_are_those_that_the_tool_tells(kind, built, tool):
    import json

    told = json.loads(tool("info", built, "--json"))["options"]
    options = kind.load(built).options
    flat = {key: value for section in told.values() for key, value in section.items()}
    assert set(options) == set(flat)
    assert options["resolution"] == 0.2 and options["maxRange"] == 8


def test_values_of_every_type():
    map = lamap.BGKMap(
        resolution=np.float64(0.25),
        blockDepth=np.int32(5),
        planar=np.bool_(True),
        freeSpace="line",
        maxRange=20,
        rayDecimation="3",
        occupiedThreshold=0.6,
        priorMap=None,
    )
    options = map.options
    assert options["resolution"] == 0.25 and options["blockDepth"] == 5 and options["planar"] is True
    assert options["freeSpace"] == "line" and options["maxRange"] == 20.0 and options["rayDecimation"] == 3
    assert lamap.BGKMap(maxrange=7).options["maxRange"] == 7  # as in an .ini file


def test_small_and_large_numbers_stay_exact():
    for number in (0.1, 1 / 3, 1e-3, 123456.789, np.nextafter(0.3, 1)):
        assert lamap.BGKMap(planar=True, planarHeight=number).options["planarHeight"] == number


def test_a_preset_comes_before_the_others():
    map = lamap.BGKMap(freeMargin=0.2, preset="thesis")
    assert map.options["preset"] == "thesis" and map.options["blockDepth"] == 3
    assert map.options["freeMargin"] == 0.2


def test_options_cannot_be_written():
    with pytest.raises(TypeError):
        lamap.BGKMap().options["resolution"] = 1


def test_a_prior_map(tmp_path, wall):
    prior = lamap.BGKMap()
    prior.insert(wall)
    prior.save(tmp_path / "prior.lamap.gz")
    map = lamap.BGKMap(priorMap=pathlib.Path(tmp_path / "prior.lamap.gz"))
    assert map.query(wall).prob.min() > 0.5
    with pytest.raises(lamap.MissingFileError, match="none.lamap.gz") as caught:
        lamap.BGKMap(priorMap=tmp_path / "none.lamap.gz")
    assert caught.value.filename == str(tmp_path / "none.lamap.gz")


WRONG = [
    (dict(maxRnge=3), 'unknown option "maxRnge"; did you mean "maxRange"?'),
    (dict(threads=3), 'unknown option "threads"; '),
    (dict(maxRange="abc"), 'insertOpts.maxRange = "abc" in section "insertOpts" is not a number; legal is 0, or a'),
    (dict(maxRange=-1), 'insertOpts.maxRange = "-1" in section "insertOpts" is out of range; legal is 0, or a'),
    (dict(maxRange=float("nan")), "is not a finite number"),
    (dict(maxRange=""), 'insertOpts.maxRange = "": must be 0, or a number'),
    (dict(maxRange=[1]), "maxRange: must be a number, a truth value or a text, not of type list"),
    (dict(rayDecimation=2.5), "rayDecimation"),
    (dict(rayDecimation=10**30), "rayDecimation"),
    (dict(planar=2), "planar"),
    (dict(freeSpace="foo"), "there are: samples, line, none"),
    (dict(freeThreshold=0.9), "occupiedThreshold = 0.55: must be a number >= freeThreshold"),
    (dict(kernelSupport=1e-9), "kernelSupport = 1e-9: must be"),
    (dict(resolution=0), "creationOpts.resolution"),
    (dict(maxRange=1, maxrange=2), "given twice"),
    (dict(priorMap="a # b"), "comment"),
    (dict(priorMap=" a"), "space"),
]


@pytest.mark.parametrize("options,message", WRONG, ids=[str(i) for i in range(len(WRONG))])
def test_wrong_options_are_named(options, message):
    with pytest.raises(ValueError) as caught:
        lamap.BGKMap(**options)
    assert message in str(caught.value)
    assert not str(caught.value).startswith("-s")


def test_words_are_those_of_the_tool(tmp_path):
    import os
    import subprocess

    command = [os.environ["LAMAP_PROGRAM"], "build", "-i", "x.rawlog", "-m", "bgkMap", "-s", "insertOpts.maxRange=-1",
               "-o", tmp_path / "x.lamap.gz"]  # fmt: skip
    told = subprocess.run(command, capture_output=True, text=True).stderr
    with pytest.raises(ValueError) as caught:
        lamap.BGKMap(maxRange=-1)
    assert told == f"lamap: -s {caught.value}\n"
