#!/usr/bin/python3
"""Draws error against order: plot_environment.py results/environment.csv results/environment.png

Needs matplotlib (scripts/setup --dev).
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter

FLOOR = 0.05  # per cent: below it the references' noise


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    scenes = {}
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if not row["variant"]:
                scenes.setdefault(row["scene"], []).append(row)
    skies = [key[:-len(" total")] for key in next(iter(scenes.values()))[0] if key.endswith(" total")]
    figure, axes = plt.subplots(1, len(scenes), figsize=(5.2 * len(scenes), 4), sharey=True,
                                squeeze=False)
    for axis, (scene, rows) in zip(axes[0], scenes.items()):
        orders = [int(row["order"]) for row in rows]
        for sky in skies:
            error = [max(FLOOR, 100 * float(row[f"{sky} total"])) for row in rows]
            noise = [100 * float(row[f"{sky} noise"]) for row in rows]
            axis.errorbar(orders, error, yerr=noise, marker="o", markersize=4, capsize=2, label=sky)
        axis.axhline(2, color="grey", linewidth=0.8, linestyle=":")
        axis.set_yscale("log")
        axis.set_ylim(FLOOR * 0.8, 100)
        axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_title(scene)
        axis.set_xlabel("order")
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel("error of irradiance at samples, %")
    axes[0][0].legend()
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
