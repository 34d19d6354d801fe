"""Scores by scikit-learn for lines "prob label" on standard input: prints one "name score" per line."""

import sys

import numpy as np
from sklearn.metrics import (
    average_precision_score,
    brier_score_loss,
    log_loss,
    precision_score,
    recall_score,
    roc_auc_score,
    roc_curve,
)

prob, label = np.loadtxt(sys.stdin, unpack=True)
label = label.astype(int)
clipped = np.clip(prob, 1e-6, 1 - 1e-6)

print("areaUnderRoc", repr(float(roc_auc_score(label, prob))))
print("averagePrecision", repr(float(average_precision_score(label, prob))))
print("logLoss", repr(float(log_loss(label, clipped))))
print("brier", repr(float(brier_score_loss(label, prob))))
for name, called in (("above", prob > 0.7), ("atLeast", prob >= 0.7)):
    print(name + "Precision", repr(float(precision_score(label, called))))
    print(name + "Recall", repr(float(recall_score(label, called))))
false_positive, true_positive, _ = roc_curve(label, prob)
# The area again, from the curve with all its points: checks the curve independently.
print("areaBelowCurve", repr(float(np.trapz(true_positive, false_positive))))
