"""A map from a log, as `lamap build` makes it, and how good it is.

Argument: a log; default: MRPT's localization_demo of the Debian package mrpt-common."""

import sys

import numpy as np

import lamap

log = sys.argv[1] if len(sys.argv) > 1 else "/usr/share/mrpt/datasets/localization_demo.simplemap.gz"

bgk = lamap.build(log, "bgk", planar=True, maxRange=10)
print(f"{bgk.report['scans']} scans:", bgk)

# A coarser map of the same log, scored by the cells of the finer one.
cells = bgk.cells()
known = np.isin(cells.state, (lamap.State.FREE, lamap.State.OCCUPIED))
coarse = lamap.build(log, "bgk", planar=True, maxRange=10, resolution=0.2)
scores = lamap.evaluate(coarse, (cells.centre[known], cells.state[known] == lamap.State.OCCUPIED))
print(f"AUC {scores['all']['auc']:.3f}, log loss {scores['all']['logLoss']:.3f}")
