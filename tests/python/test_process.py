"""The module in processes of its own: import order, the end of the interpreter, errors that nobody catches."""

import os
import subprocess
import sys

import pytest

MAKE = "import lamap, numpy as np\nmap = lamap.BGKMap()\nmap.insert(np.eye(3))\n"


def run(code, *before, **environment):
    return subprocess.run(
        [*before, sys.executable, "-c", code], capture_output=True, text=True, timeout=120, env={**os.environ, **environment}
    )


@pytest.mark.parametrize(
    "code",
    [
        "import lamap",
        MAKE,
        MAKE + "import sys; del sys.modules['lamap'], lamap; import gc; gc.collect()",
        MAKE + "import atexit; atexit.register(lambda: map.query(np.zeros((5, 3))))",
        "import numpy, lamap",
        MAKE + "import sys; sys.exit(0)",
    ],
)
def test_the_interpreter_ends_quietly(code):
    ended = run(code)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


LOAD_PLUGIN = "import ctypes, os\nctypes.CDLL(os.environ['LAMAP_PLUGIN'], ctypes.RTLD_GLOBAL)\n"
USE = MAKE + "import pickle\nassert pickle.loads(pickle.dumps(map)) == map\nassert lamap.GPMap().options\n"


@pytest.mark.parametrize("code", [LOAD_PLUGIN + USE, USE + LOAD_PLUGIN + USE], ids=["before", "after"])
def test_the_plug_in_may_be_loaded_too(code):
    ended = run(code)
    assert (ended.returncode, ended.stdout) == (0, "")
    assert all(line.startswith("[MRPT class registry] Warning") for line in ended.stderr.splitlines()), ended.stderr


def test_lamap_run_may_start_python():
    ended = run(USE, os.environ["LAMAP_PROGRAM"], "run", "--")
    assert ended.returncode == 0, ended.stderr


def test_an_error_that_nobody_catches_ends_with_a_traceback():
    ended = run("import lamap\nlamap.load('none.lamap.gz')")
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1].startswith("lamap.MissingFileError: cannot read the map file 'none.lamap.gz'")


def test_an_error_in_a_thread_ends_only_the_thread():
    code = "import threading\n" + MAKE + (
        "thread = threading.Thread(target=map.insert, args=([[1]],))\nthread.start()\nthread.join()\nprint('alive')"
    )
    ended = run(code)
    assert ended.returncode == 0 and ended.stdout == "alive\n"
    assert "ValueError: points: must have the shape" in ended.stderr


def test_a_daemon_thread_may_work_while_the_interpreter_ends():
    code = "import threading, time\n" + MAKE + (
        "def work():\n    while True:\n        map.query(np.zeros((300000, 3)))\n"
        "for _ in range(3):\n    threading.Thread(target=work, daemon=True).start()\ntime.sleep(0.3)\n"
    )
    for _ in range(3):
        ended = run(code)
        assert (ended.returncode, ended.stderr) == (0, "")


def test_a_forked_child_can_use_maps():
    code = MAKE + (
        "import os\nmap.query(np.zeros((50000, 3)))\nchild = os.fork()\nif child == 0:\n"
        "    map.insert(np.eye(3) * 2)\n    assert (map.query(np.eye(3)[[0] * 50000] * 2).state == 2).all()\n"
        "else:\n    assert os.waitpid(child, 0)[1] == 0\n"
    )
    for _ in range(3):
        ended = run(code)
        assert ended.returncode == 0, ended.stderr


def test_a_child_that_is_forked_among_working_threads_ends():
    code = "import os, threading\n" + MAKE + (
        "map.threads = 1\nstop = threading.Event()\n"
        "def work():\n    while not stop.is_set():\n        map.query(np.zeros((5000, 3)))\n"
        "threads = [threading.Thread(target=work) for _ in range(3)]\n"
        "for thread in threads:\n    thread.start()\n"
        "for _ in range(3):\n    child = os.fork()\n    if child == 0:\n        break\n"
        "    assert os.waitpid(child, 0)[1] == 0\nstop.set()\n"
    )
    ended = run(code)
    assert ended.returncode == 0, ended.stderr


def test_the_module_shows_no_symbols_but_its_own():
    import lamap

    symbols = subprocess.run(["nm", "-D", "--defined-only", lamap.__file__], capture_output=True, text=True, check=True)
    assert [line.split()[-1] for line in symbols.stdout.splitlines()] == ["PyInit_lamap"]
    dynamic = subprocess.run(["readelf", "-d", lamap.__file__], capture_output=True, text=True, check=True).stdout
    assert "NODELETE" in dynamic and "libmrpt-lamap" not in dynamic and "RUNPATH" not in dynamic
