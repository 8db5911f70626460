"""Bakes one scene with many settings and says what each brought; for error_budget and sweep."""
import json
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
JUDGES = ("reference", "evaluate")  # stages that measure the error and make nothing


class Study:
    """All bakes of a study share a folder, so that each makes only what its settings change."""

    def __init__(self, config, folder, settings=(), programs="build/release/bin"):
        self.config = config
        self.folder = folder
        self.settings = list(settings)
        self.options = {}  # of the bake with the study's own settings, once it was made
        self.program = os.path.join(ROOT, programs, "prt_bake")

    def bake(self, *settings):
        """Figures of a bake with `key=value` settings on top of the study's own."""
        command = [self.program, self.config, "--out", self.folder, "--quiet"]
        for setting in (*self.settings, *settings):
            command += ["--set", setting]
        environment = {k: v for k, v in os.environ.items() if not k.startswith("OMPI_COMM")}
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr.strip()}")
        with open(os.path.join(self.folder, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
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
        "indirect_of_exact": indirect["exact_direct"]["rel_rmse"],
        "direct": direct["rel_rmse"],
        "direct_error": both(direct),
        "direct_median": direct["rel_rmse_light"]["median"],
        "direct_surface": direct["surface"]["rel_rmse"],
        "visibility": error["visibility_error"],
        "cpu_seconds": sum(s["cpu_seconds"] for s in made),
        "bytes": report["package_bytes"],
    }
