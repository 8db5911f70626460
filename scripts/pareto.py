"""What of a sweep is worth its cost; for sweep and results/bench/plot_sweeps.py.

A row is a dictionary of numbers as sweep writes it. `gap` figures are differences to the row of the
defaults under the same lights, with a standard error that has the common noise taken out.
"""

COSTS = ("cpu_seconds", "bytes")
ERRORS = ("indirect", "direct_median")
SURE = 2.0  # standard errors that make a difference one
SAME = 0.05  # share of the defaults' error within which another is as good
CHEAPER = 0.1  # share of the cost that is worth a change; CPU seconds repeat to some 5 %


def front(rows, cost, error):
    """Rows that no other undercuts in both, from cheap to dear."""
    kept = []
    for row in sorted(rows, key=lambda r: (r[cost], r[error])):
        if not kept or row[error] < kept[-1][error]:
            kept.append(row)
    return kept


def better(row, error):
    return row[f"{error}_gap"] < -SURE * row[f"{error}_gap_error"]


def as_good(row, default, error):
    return row[f"{error}_gap"] + SURE * row[f"{error}_gap_error"] < SAME * default[error]


def beats(row, default, cost):
    """Why the row is beyond noise a better choice than the defaults at this cost; empty if not.
    More accurate for no more, or as accurate for clearly less; in neither error worse."""
    if row[cost] > default[cost]:
        return ""
    gains = [error for error in ERRORS if better(row, error)]
    if not all(as_good(row, default, error) or error in gains for error in ERRORS):
        return ""
    if gains:
        return f"less {' and '.join(gains)} error for no more"
    return "as good for less" if row[cost] < (1 - CHEAPER) * default[cost] else ""
