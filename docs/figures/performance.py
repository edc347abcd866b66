"""Time of one solve beside other programs, from benchmarks/results.json."""

import matplotlib.pyplot as plt

import report

report.plot(report.stored(), plt.figure(figsize=(9, 4), layout="constrained"))
