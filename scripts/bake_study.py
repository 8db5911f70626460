"""Bakes one scene with many settings and says what each brought; for error_budget and sweep."""
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAMS = os.environ.get("PRT_BIN", os.path.join(ROOT, "build/release/bin"))
JUDGES = ("reference", "compare", "evaluate")  # stages that measure the error and make nothing
MOST = {"lb.visibility_rank": 1000, "lb.light_rank": 1000, "rays.directions": 8064}
LEAST = {"lb.near_share": 1e-4, "compression.tolerance": 1e-6, "transport.tolerance": 1e-6}


def settings_of(changes, options):
    """`key=value` of changes `key*factor`, `key/factor` and `key=value` of a bake with `options`;
    none where they change nothing."""
    settings = []
    for change in changes:
        for sign, apply in (("*", lambda a, b: a * b), ("/", lambda a, b: a / b)):
            if sign not in change:
                continue
            key, factor = change.split(sign)
            now = options[key]
            value = type(now)(apply(now, type(now)(factor)))
            value = min(value, MOST.get(key, value))
            value = max(value, LEAST.get(key, value))
            break
        else:
            key, value = change.split("=")
            now = options[key]
        if str(value) != str(now):
            settings.append(f"{key}={value}")
    return settings


class Study:
    """All bakes of a study share a folder, so that each makes only what its settings change."""

    def __init__(self, config, folder, settings=(), threads=None):
        self.config = config
        self.folder = folder
        self.settings = list(settings)
        self.threads = threads
        self.options = {}  # of the bake with the study's own settings, once it was made
        self.package = ""  # of the last bake

    def bake(self, *settings):
        """Figures of a bake with `key=value` settings on top of the study's own."""
        command = [os.path.join(PROGRAMS, "prt_bake"), self.config, "--out", self.folder, "--quiet"]
        if self.threads:
            command += ["--threads", str(self.threads)]
        for setting in (*self.settings, *settings):
            command += ["--set", setting]
        environment = {k: v for k, v in os.environ.items() if not k.startswith("OMPI_COMM")}
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        if done.returncode == 2:  # the user's settings or scene, and the bake says so in one line
            print(done.stderr.strip(), file=sys.stderr)
            raise SystemExit(2)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr.strip()}")
        with open(os.path.join(self.folder, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
        self.package = os.path.join(self.folder, report["package"])
        if not settings:
            self.options = report["options"]
        return figures(report)


def both(error):
    """Standard error of a figure: noise of the reference and choice of lights."""
    return (error["standard_error"] ** 2 + error["light_error"] ** 2) ** 0.5


def figures(report):
    """What is compared between bakes. CPU seconds are those of the tasks the package hangs on,
    whenever they were made: others' work on the machine hardly shows in them."""
    error = report["error"]
    if error is None:
        raise SystemExit("evaluate.lights or evaluate.points is 0: there is no error to study")
    made = [s for s in report["stages"] if s["stage"] not in JUDGES]
    direct, indirect = error["direct"], error["indirect"]
    return {
        "indirect": indirect["rel_rmse"],
        "indirect_noise": indirect["standard_error"],
        "indirect_error": both(indirect),
        "indirect_median": indirect["rel_rmse_light"]["median"],
        "indirect_surface": indirect["surface"]["rel_rmse"],
        "indirect_surface_error": both(indirect["surface"]),
        "indirect_of_exact": indirect["exact_direct"]["rel_rmse"],
        "direct": direct["rel_rmse"],
        "direct_error": both(direct),
        "direct_median": direct["rel_rmse_light"]["median"],
        "direct_surface": direct["surface"]["rel_rmse"],
        "direct_surface_error": both(direct["surface"]),
        "visibility": error["visibility_error"],
        "cpu_seconds": sum(s["cpu_seconds"] for s in made),
        "bytes": report["package_bytes"],
    }
