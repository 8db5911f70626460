"""Runs scripts/sweep on tiny bakes, stops it, breaks it, and checks how it judges."""

import csv
import importlib.machinery
import importlib.util
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCRIPT = ROOT / "scripts/sweep"
sys.path.insert(0, str(ROOT / "scripts"))

import bake_study
import pareto

# The script's sums are in double, the bake's per-light errors were rounded to float.
ROUNDING = 1e-5
WALL = ("play_ms",)  # differs from run to run


def load_sweep():
    loader = importlib.machinery.SourceFileLoader("sweep", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("sweep", loader))
    loader.exec_module(module)
    return module


sweep = load_sweep()


def run(*words):
    return subprocess.run([sys.executable, "-B", SCRIPT, *map(str, words)], capture_output=True,
                          text=True, check=False)


class QuickSweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.words = ["--quick", "--axis", "d1", "--axis", "photons", "--out", cls.folder]
        cls.done = run(*cls.words)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @property
    def table(self):
        return self.folder / "sweeps.csv"

    def rows(self):
        with open(self.table, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def settled(self):
        return [{k: v for k, v in row.items() if k not in WALL} for row in self.rows()]

    def setUp(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)

    def test_makes_every_row_of_the_axes(self):
        made = [(row["axis"], row["value"]) for row in self.rows()]
        self.assertEqual(made, [("default", ""), *(("d1", v) for v in ("2", "4", "16", "32", "64")),
                                *(("photons", v) for v in ("1000", "4000", "16000", "64000"))])
        for row in self.rows():
            for name in set(sweep.COLUMNS) - set(sweep.TEXTS):
                self.assertTrue(math.isfinite(float(row[name])), name)

    def test_figures_are_those_of_the_setting(self):
        rows = {(row["axis"], row["value"]): row for row in self.rows()}
        coarse, fine = rows["d1", "2"], rows["d1", "64"]
        self.assertGreater(float(coarse["direct_median"]), float(fine["direct_median"]))
        self.assertLess(int(coarse["bytes"]), int(fine["bytes"]))
        photons = [float(rows["photons", v]["indirect"]) for v in ("1000", "64000")]
        self.assertGreater(*photons)
        default = rows["default", ""]
        self.assertAlmostEqual(float(fine["direct_median_gap"]),
                               float(fine["direct_median"]) - float(default["direct_median"]), delta=1e-5)

    def test_common_noise_cancels_in_differences(self):
        rows = {(row["axis"], row["value"]): row for row in self.rows()}
        self.assertEqual(float(rows["default", ""]["indirect_gap_error"]), 0.0)
        # Shadows hardly show in indirect light: lights and references are the noise of both.
        near = rows["d1", "16"]
        self.assertGreater(float(near["indirect_gap_error"]), 0.0)
        self.assertLess(float(near["indirect_gap_error"]), float(near["indirect_error"]) / 4)

    def test_goes_on_where_it_stopped(self):
        before = self.settled()
        lines = self.table.read_text(encoding="utf-8").splitlines(keepends=True)
        self.table.write_text("".join(lines[:4] + lines[6:]), encoding="utf-8")
        again = run(*self.words)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(sorted(map(str, self.settled())), sorted(map(str, before)))
        made = [line.split()[1] for line in again.stdout.splitlines() if " MB " in line]
        self.assertEqual(made, ["default", "d1", "d1"])

    def test_complete_table_bakes_nothing(self):
        index = self.folder / "cornell/bake.h5"
        stamp = index.stat().st_mtime_ns
        again = run(*self.words)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(index.stat().st_mtime_ns, stamp)
        self.assertNotIn(" MB ", again.stdout, "the verdict alone")

    def test_refuses_rows_of_other_defaults(self):
        other = self.folder / "other.csv"
        text = self.table.read_text(encoding="utf-8").replace("lb.light_rank=4", "lb.light_rank=5")
        other.write_text("".join(text.splitlines(keepends=True)[:-1]), encoding="utf-8")
        again = run(*self.words, "--csv", other)
        self.assertEqual(again.returncode, 2, again.stderr)
        self.assertIn("other defaults", again.stderr)

    def test_sums_over_lights_give_the_pooled_error(self):
        # Photons this few: no light's error drowns in the noise of its references.
        study = bake_study.Study(str(ROOT / "configs/default.yaml"), str(self.folder / "cornell"),
                                 ["evaluate.lights=6", "evaluate.spp=256", *sweep.QUICK], 1)
        figures = study.bake("lb.solver=photons", "lb.photons=1000")
        lights = sweep.LightErrors(study.folder)
        indirect, direct = lights.figures([range(6)])
        self.assertAlmostEqual(indirect[0] / figures["indirect"], 1.0, delta=ROUNDING)
        self.assertAlmostEqual(direct[0] / figures["direct_median"], 1.0, delta=ROUNDING)


class Rubbish(unittest.TestCase):
    def test_ends_with_one_line_and_exit_code_2(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            foreign = folder / "foreign.csv"
            foreign.write_text("a,b\n1,2\n", encoding="utf-8")
            other = folder / "other.csv"
            row = dict.fromkeys(sweep.COLUMNS, "1") | {"scene": "cornell", "axis": "default"}
            other.write_text(",".join(row) + "\n" + ",".join(row.values()) + "\n", encoding="utf-8")
            spoiled = folder / "spoiled.csv"
            row |= {"bytes": "many"}
            spoiled.write_text(",".join(row) + "\n" + ",".join(row.values()) + "\n", encoding="utf-8")
            quick = ["--quick", "--out", folder / "bakes"]
            for words in ([], ["nowhere.glb"], ["gallery", "gallery"], ["gallery", "--axis", "d3"],
                          ["gallery", "--lights", "0"], ["gallery", "--spp", "many"],
                          ["gallery", "--threads", "-1"], ["--rubbish"],
                          [*quick, "--csv", foreign], [*quick, "--csv", other],
                          [*quick, "--csv", spoiled], [*quick, "--csv", folder],
                          ["--quick", "--out", foreign], [SCRIPT, *quick]):
                with self.subTest(words=words):
                    done = run(*words)
                    self.assertEqual(done.returncode, 2, done.stderr)
                    self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                    self.assertEqual(list(folder.rglob("*.prt.glb")), [])


class Changes(unittest.TestCase):
    OPTIONS = {"lb.visibility_rank": 50, "compression.tolerance": 0.01, "lb.solver": "gather",
               "lb.photons": 2000000, "rays.directions": 8064}

    def test_multiply_divide_and_set(self):
        settings = bake_study.settings_of
        self.assertEqual(settings(["lb.visibility_rank/4"], self.OPTIONS), ["lb.visibility_rank=12"])
        self.assertEqual(settings(["compression.tolerance*10"], self.OPTIONS),
                         ["compression.tolerance=0.1"])
        self.assertEqual(settings(["lb.solver=photons"], self.OPTIONS), ["lb.solver=photons"])

    def test_what_changes_nothing_is_left_out(self):
        for change in ("lb.solver=gather", "lb.photons*1", "rays.directions*2"):
            self.assertEqual(bake_study.settings_of([change], self.OPTIONS), [], change)


def row(cost, indirect, direct=0.0, noise=0.001, size=7):
    """Beside defaults of cost 10, size 7 and errors 0.1: figures as differences to them."""
    figures = {"cpu_seconds": cost, "bytes": size}
    figures |= {"indirect": 0.1 + indirect, "direct_median": 0.1 + direct}
    for error, gap in (("indirect", indirect), ("direct_median", direct)):
        figures |= {f"{error}_gap": gap, f"{error}_gap_error": noise}
    return figures


class Pareto(unittest.TestCase):
    def test_front_is_what_nothing_undercuts(self):
        rows = [row(10, 0.0), row(5, 0.02), row(6, 0.03), row(20, -0.05), row(20, -0.04), row(5, 0.01)]
        front = pareto.front(rows, "cpu_seconds", "indirect")
        self.assertEqual(front, [rows[5], rows[0], rows[3]])

    def test_defaults_are_beaten_only_beyond_noise(self):
        default = row(10, 0.0, noise=0.0)
        for other, beaten in (
            (row(10, -0.01), True),  # less error, no dearer
            (row(10.1, -0.01), False),  # ... dearer
            (row(10, -0.01, noise=0.006), False),  # ... within two standard errors
            (row(10, -0.004), False),  # ... hardly less
            (row(10, -0.01, direct=0.01), False),  # ... the other error worse
            (row(8, 0.0), True),  # as good for less
            (row(9.5, 0.0), False),  # ... hardly less
            (row(8, 0.0, noise=0.004), False),  # ... it cannot be told whether as good
            (row(8, 0.004), False),
            (row(8, 0.0, direct=0.02), False),
            (row(10, -0.01, size=8), False),  # ... more bytes
            (row(10, 0.0, size=6), True),
        ):
            with self.subTest(other=other):
                self.assertEqual(bool(pareto.beats(other, default)), beaten)
        self.assertEqual(pareto.beats(default, default), "")

    def test_undercut_looks_at_one_error_and_one_cost(self):
        default = row(10, 0.0, noise=0.0)
        rows = [default, row(9, -0.01, direct=0.05, size=9), row(9, -0.02, noise=0.02), row(11, -0.03)]
        self.assertIs(pareto.undercut(rows, default, "cpu_seconds", "indirect"), rows[1])
        self.assertIsNone(pareto.undercut(rows, default, "bytes", "direct_median"))


if __name__ == "__main__":
    unittest.main()
