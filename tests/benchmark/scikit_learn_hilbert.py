"""Trains and queries the Hilbert model of each scan with scikit-learn, as in the thesis, and times both.

usage: scikit_learn_hilbert.py FOLDER PASSES

PASSES over the training points; 0: scikit-learn's default, until the loss has settled.
FOLDER contains for each scan number n, counted from 0, in native binary format:
  points_<n>.f64   x y z of the training points [m]
  labels_<n>.f64   1 (occupied) or 0 (free) for each
  cells_<n>.f64    x y z of the centres of the cells to query [m]
The script adds
  logodds_<n>.f64  the model's log-odds for each cell
  times.txt        one line per scan: seconds of training, seconds of queries, passes over the training points
"""

import os
import sys

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"):
    os.environ[variable] = "1"  # before numpy reads them

import numpy as np  # noqa: E402
from sklearn.kernel_approximation import Nystroem  # noqa: E402
from sklearn.linear_model import SGDClassifier  # noqa: E402
from time import perf_counter  # noqa: E402

GAMMA = 3.0  # [1/m^2], thesis 3.2
COMPONENTS = 100
ALPHA = 1e-5
CELLS_AT_ONCE = 5000  # few enough to stay in the cache: a quarter faster than all cells in one call


def numbers(folder, name, columns):
    return np.fromfile(os.path.join(folder, name)).reshape(-1, columns)


def train(points, labels, passes):
    features = Nystroem(kernel="rbf", gamma=GAMMA, n_components=min(COMPONENTS, len(points)), random_state=1)
    until = {"max_iter": passes, "tol": None} if passes > 0 else {}
    classifier = SGDClassifier(loss="log_loss", penalty="l1", alpha=ALPHA, random_state=1, **until)
    classifier.fit(features.fit_transform(points), labels)
    return features, classifier


def ask(features, classifier, cells):
    parts = [cells[i : i + CELLS_AT_ONCE] for i in range(0, len(cells), CELLS_AT_ONCE)]
    return np.concatenate([classifier.decision_function(features.transform(part)) for part in parts])


def main(folder, passes):
    times = open(os.path.join(folder, "times.txt"), "w")
    scan = 0
    while os.path.exists(os.path.join(folder, f"points_{scan}.f64")):
        points = numbers(folder, f"points_{scan}.f64", 3)
        labels = numbers(folder, f"labels_{scan}.f64", 1).ravel()
        cells = numbers(folder, f"cells_{scan}.f64", 3)
        start = perf_counter()
        features, classifier = train(points, labels, passes)
        trained = perf_counter()
        logodds = ask(features, classifier, cells)
        asked = perf_counter()
        np.asarray(logodds, dtype=np.float64).tofile(os.path.join(folder, f"logodds_{scan}.f64"))
        times.write(f"{trained - start} {asked - trained} {classifier.n_iter_}\n")
        scan += 1
    times.close()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: scikit_learn_hilbert.py FOLDER PASSES")
    main(sys.argv[1], int(sys.argv[2]))
