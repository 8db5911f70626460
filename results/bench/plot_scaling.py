#!/usr/bin/python3
"""Draws speed-up and efficiency over ranks: plot_scaling.py results/scaling.csv results/scaling.png"""
import csv
import sys
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Workload in the CSV, what it is called in the plot, line style.
SHOWN = [
    ("gallery", "gallery, 45,000 samples", "C0-o"),
    ("gallery-all", "gallery, all changes", "C0--^"),
    ("sponza", "sponza, 45,000 samples", "C1-o"),
    ("city", "city, 10 M samples, in regions", "C3-o"),
    ("city-all", "city, all changes", "C3--^"),
]


def read(path):
    rows = defaultdict(list)
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows[row["workload"]].append(
                (int(row["ranks"]), float(row["speed_up"]), float(row["efficiency"]))
            )
    return rows


def main():
    rows = read(sys.argv[1])
    figure, (speed, share) = plt.subplots(1, 2, figsize=(10, 4.2))
    most = max(ranks for points in rows.values() for ranks, _, _ in points)
    speed.plot([1, most], [1, most], color="0.7", linewidth=1, label="ideal")
    for name, label, style in SHOWN:
        ranks, speed_up, efficiency = zip(*rows[name])
        speed.plot(ranks, speed_up, style, markersize=3, linewidth=1, label=label)
        share.plot(ranks, efficiency, style, markersize=3, linewidth=1)
    for ranks, goal in ((100, 0.8), (1000, 0.5)):
        share.plot(ranks, goal, "k*", markersize=9)
    share.annotate("goals for the city", (100, 0.8), (130, 0.86), fontsize=8)
    speed.set(xscale="log", yscale="log", xlabel="ranks", ylabel="speed-up (simulated)")
    share.set(xscale="log", ylim=(0, 1.35), xlabel="ranks", ylabel="efficiency (simulated)")
    speed.legend(fontsize=7)
    for axes in (speed, share):
        axes.grid(True, which="major", color="0.9")
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
