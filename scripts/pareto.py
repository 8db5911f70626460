"""What of a sweep is worth its cost; for sweep and results/bench/plot_sweeps.py.

A row is a dictionary of numbers as sweep writes it. `gap` figures are differences to the row of the
defaults under the same lights, with a standard error that has the common noise taken out.
"""

COSTS = ("cpu_seconds", "bytes")
ERRORS = ("indirect", "direct_median")
SURE = 2.0  # standard errors that make a difference one
SAME = 0.05  # share of the defaults' error within which another is as good
CHEAPER = 0.1  # share of a cost that is worth a change


def front(rows, cost, error):
    """Rows that no other undercuts in both, from cheap to dear."""
    kept = []
    for row in sorted(rows, key=lambda r: (r[cost], r[error])):
        if not kept or row[error] < kept[-1][error]:
            kept.append(row)
    return kept


def better(row, default, error):
    noise = SURE * row[f"{error}_gap_error"]
    return row[f"{error}_gap"] < -max(noise, SAME * default[error])


def as_good(row, default, error):
    return row[f"{error}_gap"] + SURE * row[f"{error}_gap_error"] < SAME * default[error]


def undercut(rows, default, cost, error):
    """The most accurate row of those that cost no more and are beyond noise better in this error."""
    found = [row for row in rows if row[cost] <= default[cost] and better(row, default, error)]
    return min(found, key=lambda row: row[error], default=None)


def beats(row, default):
    """Why the row is beyond noise a better choice than the defaults; empty if not. Neither cost is
    higher and neither error worse, and one of them is clearly lower."""
    if any(row[cost] > default[cost] for cost in COSTS):
        return ""
    gains = [error for error in ERRORS if better(row, default, error)]
    if not all(as_good(row, default, error) or error in gains for error in ERRORS):
        return ""
    if gains:
        return f"less {' and '.join(gains)} error for no more"
    cheaper = any(row[cost] < (1 - CHEAPER) * default[cost] for cost in COSTS)
    return "as good for less" if cheaper else ""
