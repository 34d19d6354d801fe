"""Building from logs, and scoring: the same as the tool's."""

import json
import os
import signal
import threading
import time

import numpy as np
import pytest

import lamap


def test_the_map_is_that_of_the_tool_byte_for_byte(kind, built, world, tmp_path):
    for map_name in (kind, kind.alias, kind.alias[:-3]):
        map = lamap.build(world / "log.rawlog", map_name, resolution=0.2, maxRange=8, threads=1)
        assert type(map) is kind
        map.save(tmp_path / "map.lamap.gz")
        assert (tmp_path / "map.lamap.gz").read_bytes() == built.read_bytes()


def test_the_report_is_that_of_the_tool(world, tmp_path, tool):
    out = tmp_path / "map.lamap.gz"
    told = json.loads(tool("build", "-i", world / "log.rawlog", "-m", "bgkMap", "-o", out, "--json"))
    report = lamap.build(world / "log.rawlog").report
    for key in ("scans", "used", "rays", "notes", "inputs", "left_out", "map"):
        assert report[key] == told[key]
    assert lamap.BGKMap().report is None


def test_keywords_are_the_flags(world, tmp_path, tool):
    settings = tmp_path / "map.ini"
    settings.write_text("[map]\nbgkMap_count=1\n[map_bgkMap_00_creationOpts]\nresolution=0.25\n")
    tool("build", "-i", world / "log.rawlog", "-c", settings, "--poses", world / "log.tum", "--every", 2, "--from", 0,
         "-o", tmp_path / "tool.lamap.gz")  # fmt: skip
    map = lamap.build([world / "log.rawlog"], None, config=settings, poses=world / "log.tum", every=2, from_time=0)
    assert map == lamap.load(tmp_path / "tool.lamap.gz") and map.report["scans"] == 1
    more = lamap.build(world / "log.rawlog", None, onto=tmp_path / "tool.lamap.gz")
    assert more.resolution == 0.25 and more != map
    with pytest.raises(ValueError, match="resolution"):
        lamap.build(world / "log.rawlog", None, onto=tmp_path / "tool.lamap.gz", resolution=0.5)
    with pytest.raises(ValueError, match="which|map"):
        lamap.build(world / "log.rawlog", None)


def write_pcd(path, points, viewpoint="0 0 0 1 0 0 0"):
    head = f"VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n"
    rows = "\n".join(" ".join(repr(float(number)) for number in point) for point in points)
    path.write_text(f"{head}VIEWPOINT {viewpoint}\nPOINTS {len(points)}\nDATA ascii\n{rows}\n")


def test_clouds_in_files_are_as_clouds_in_arrays(kind, wall, tmp_path):
    write_pcd(tmp_path / "1.pcd", wall + [1, 0, 0], "1 0 0 1 0 0 0")
    write_pcd(tmp_path / "2.pcd", wall)
    from_files, from_arrays = lamap.build(tmp_path, kind), kind()
    from_arrays.insert(wall + [1, 0, 0], origin=[1, 0, 0])
    from_arrays.insert(wall)
    assert from_files == from_arrays
    in_sensor = lamap.build(tmp_path / "2.pcd", kind, cloud_frame="sensor", sensor_origin=[0, 0, 1])
    raised = kind()
    raised.insert(wall, origin=[0, 0, 1])
    assert in_sensor == raised


def test_what_cannot_be_built(tmp_path, world):
    with pytest.raises(FileNotFoundError, match="none.rawlog") as caught:
        lamap.build(tmp_path / "none.rawlog")
    assert caught.value.filename == str(tmp_path / "none.rawlog")
    (tmp_path / "damaged.rawlog").write_bytes(b"no log")
    with pytest.raises(OSError, match="damaged.rawlog"):
        lamap.build(tmp_path / "damaged.rawlog")
    wrong = [
        (dict(map="bgj"), ValueError, "did you mean bgk"),
        (dict(map=3), ValueError, "map: must be"),
        (dict(mxRange=1), ValueError, "did you mean"),
        (dict(maxRange=-1), ValueError, "out of range"),
        (dict(cloud_frame="moon"), ValueError, "'moon' is none of: map, sensor"),
        (dict(every="a"), TypeError, "every"),
        (dict(every=0), ValueError, "every"),
        (dict(threads=-1), TypeError, "threads"),
        (dict(sensors="none"), OSError, "none"),
        (dict(from_time="never"), ValueError, "from_time never"),
        (dict(ping_beam=[1, 2, 3]), ValueError, "ping_beam: must be one number or two"),
        (dict(sensor_origin=[1, 2]), ValueError, "sensor_origin"),
        (dict(poses=tmp_path / "none.tum"), FileNotFoundError, "none.tum"),
        (dict(config=tmp_path / "none.ini"), FileNotFoundError, "none.ini"),
        (dict(onto=tmp_path / "none.lamap.gz"), FileNotFoundError, "none.lamap.gz"),
    ]
    for keywords, error, message in wrong:
        with pytest.raises(error, match=message):
            lamap.build(world / "log.rawlog", **keywords)
    with pytest.raises(ValueError, match="names no file"):
        lamap.build([])
    settings = tmp_path / "octo.ini"
    settings.write_text("[map]\noctoMap_count=1\n")
    with pytest.raises(OSError, match="not one of this library's maps"):
        lamap.build(world / "log.rawlog", None, config=settings)


def test_a_log_that_is_cut_short_gives_what_could_be_read(world, tmp_path):
    whole = (world / "log.rawlog").read_bytes()
    (tmp_path / "cut.rawlog").write_bytes(whole[: len(whole) * 3 // 4])
    with pytest.warns(RuntimeWarning, match="cut.rawlog: cut short or damaged"):
        map = lamap.build(tmp_path / "cut.rawlog")
    assert map.report["scans"] == 1 and map.report["inputs"][0]["damages"]
    with pytest.raises(OSError, match="cut.rawlog"):
        lamap.build(tmp_path / "cut.rawlog", strict=True)


def test_notes_go_to_logging_and_nothing_to_the_terminal(world, caplog, capfd):
    caplog.set_level("INFO", "lamap")
    map = lamap.build(world / "log.rawlog")
    told = [record.message for record in caplog.records if record.name == "lamap"]
    for note in map.report["inputs"][0]["notes"]:
        assert any(note in message for message in told)
    assert capfd.readouterr() == ("", "")


def test_progress_is_told(world):
    seen = []
    lamap.build(world / "log.rawlog", progress=lambda *progress: seen.append(progress))
    done, expected, path = seen[-1]
    assert done == expected and path == str(world / "log.rawlog")


def test_what_progress_raises_comes_out(world):
    class Enough(Exception):
        pass

    def stop(*_):
        raise Enough

    with pytest.raises(Enough):
        lamap.build(world / "log.rawlog", progress=stop)


def test_ctrl_c_stops_a_build(wall, tmp_path):
    write_pcd(tmp_path / "scan.pcd", np.vstack([wall * (1 + 0.01 * i) for i in range(40)]))
    seen = []
    begun = threading.Event()

    def interrupt():
        begun.wait()
        time.sleep(0.1)
        os.kill(os.getpid(), signal.SIGINT)

    def watch(*progress):
        seen.append(progress)
        begun.set()

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        lamap.build([tmp_path / "scan.pcd"] * 3000, "gp", progress=watch)
    thread.join()
    done, expected, _ = seen[-1]
    assert expected == 3000 and done < 3000


def test_scores_are_those_of_the_tool(kind, built, world, tool):
    told = json.loads(tool("eval", built, "--truth", world / "truth.csv", "--thresholds", "0.5,0.7", "--json"))
    map = kind.load(built)
    scores = lamap.evaluate(map, world / "truth.csv", thresholds=[0.5, 0.7])
    expected = told["maps"][0]
    for key in expected:
        assert key == "map" or scores[key] == expected[key]
    assert scores["all"]["auc"] > 0.8
    table = np.loadtxt(world / "truth.csv", delimiter=",", skiprows=1)
    in_memory = lamap.evaluate(map, (table[:, :3], table[:, 3] == 1), thresholds=(0.5, 0.7))
    assert in_memory["all"] == scores["all"] and in_memory["geometry"] == scores["geometry"]


def test_truths_that_cannot_be_used(built, world, tmp_path):
    map = lamap.load(built)
    centres, labels = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1]]), np.array([True, False])
    with pytest.raises(FileNotFoundError, match="none.csv"):
        lamap.evaluate(map, tmp_path / "none.csv")
    with pytest.raises(FileNotFoundError, match="none.csv"):
        lamap.evaluate(map, world / "truth.csv", surface=tmp_path / "none.csv")
    (tmp_path / "bad.csv").write_text("x,y,z,label\n1,2,3,7\n")
    with pytest.raises(OSError, match="label is '7'"):
        lamap.evaluate(map, tmp_path / "bad.csv")
    for truth, message in [
        ((centres,), "truth: must be"),
        ((centres[:0], labels[:0]), "holds no cell"),
        ((centres * [1, 1, np.nan], labels), "not finite"),
        ((centres[[0, 0]], labels), "occurs twice"),
        ((centres, labels[:1]), "occupied: must have the shape"),
        ((centres + 500, labels), "observed none|no cell"),
    ]:
        with pytest.raises(ValueError, match=message):
            lamap.evaluate(map, truth)
    with pytest.raises(ValueError, match="thresholds"):
        lamap.evaluate(map, (centres, labels), thresholds=[2])
    with pytest.raises(ValueError, match="empty|no cell|observed"):
        lamap.evaluate(type(map)(), (centres, labels))


def test_other_threads_run_while_a_file_is_read(built, world, tmp_path):
    """The file is a pipe, which another thread of Python fills only once it is being read."""
    pipe = tmp_path / "truth.csv"
    os.mkfifo(pipe)
    map = lamap.load(built)
    text = (world / "truth.csv").read_bytes()
    writer = threading.Thread(target=lambda: pipe.write_bytes(text), daemon=True)
    writer.start()
    assert lamap.evaluate(map, pipe)["all"] == lamap.evaluate(map, world / "truth.csv")["all"]
    writer.join()
