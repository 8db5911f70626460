#!/usr/bin/env python3
"""Breaks guards of the service one at a time and sees whether a test notices.

    scripts/mutants.py [--list] [NAME...]     all, or those whose name contains one of NAME

Each mutant is one text of the sources replaced by another, built in a copy (build/mutants) and run
against the test that should turn red. Exit code 0: all were noticed. It takes about ten minutes, most
of it building the copy.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
COPY = ROOT / "build/mutants/source"
BUILD = ROOT / "build/mutants/build"
PATIENCE = 5  # times what a test takes undisturbed: a bake that does not end is noticed, too

COORDINATOR = "src/jobs/coordinator.cpp"
WORKER = "src/jobs/worker.cpp"
STORE = "src/store/file_system.cpp"
MANIFEST = "src/store/manifest.cpp"
RESULTS = "src/apps/bake/bake_results.cpp"
JOBS_TEST = "jobs_test"
FAULTS_TEST = "storage_faults_test"
STORE_TEST = "store_test"

# name, file, text (found once), replacement, test
MUTANTS = [
    ("lost worker keeps its tasks", COORDINATOR,
     "present) return;\n  lose(it->second);", "present) return;", JOBS_TEST),
    ("lost worker is still offered", COORDINATOR,
     "  withdraw(event.worker, it->second);\n", "", JOBS_TEST),
    ("rejoined worker keeps its tasks", COORDINATOR, "  lose(worker);\n", "", JOBS_TEST),
    ("rejoined worker keeps its places", COORDINATOR,
     "  give_up_places(worker);\n", "", JOBS_TEST),
    ("woken worker gets no work", COORDINATOR, "    offer(id, it->second);\n", "", JOBS_TEST),
    ("lost worker keeps its places", COORDINATOR, "places_[place].holder = -1;", "(void)place;",
     JOBS_TEST),
    ("places are not kept to", COORDINATOR, "  if (unplaced_.empty()) return own;\n",
     "  if (unplaced_.empty()) return ready_;\n", JOBS_TEST),
    ("one's own place before longer tasks", COORDINATOR,
     "ready_.key_comp()(*own.begin(), *unplaced_.begin()) ? own : unplaced_", "own", JOBS_TEST),
    ("somebody else's place before nobody's", COORDINATOR,
     "return unplaced_.empty() ? ready_ : unplaced_;", "return ready_;", JOBS_TEST),
    ("who is free and served is not known", COORDINATOR,
     "  if (!worker.ready.empty()) served_.insert(id);\n", "", JOBS_TEST),
    ("what was ready before its place was taken", COORDINATOR,
     "    if (unplaced_.erase(task) > 0) worker.ready.insert(task);\n", "    (void)task;\n", JOBS_TEST),
    ("leases never end", COORDINATOR,
     "now_ - worker.heard > settings_.lease_seconds", "false", JOBS_TEST),
    ("first tick ends all leases", COORDINATOR, "if (!clock_started_)", "if (false)", JOBS_TEST),
    ("late worker is not sent home", COORDINATOR,
     "  if (stopped_) commands_.emplace_back(Dismiss{event.worker, ExitCode::kInterrupted});\n", "",
     JOBS_TEST),
    ("a task planned twice differently", COORDINATOR, "if (!same) fail(", "if (false) fail(", JOBS_TEST),
    ("plans with a cycle", COORDINATOR, "return reached != waits.size();", "return false;", JOBS_TEST),
    ("inputs that are done count as missing", COORDINATOR,
     "if (tasks_[input].state != State::kDone) ++tasks_[index].missing;", "++tasks_[index].missing;",
     JOBS_TEST),
    ("released before its inputs are there", COORDINATOR,
     "  if (task.missing == 0) make_ready(index);", "  make_ready(index);", JOBS_TEST),
    ("result of another key", COORDINATOR,
     "index == kUnknown || tasks_[index].key != event.key", "index == kUnknown", JOBS_TEST),
    ("two contents for one key", COORDINATOR, "known->second != event.content", "false", JOBS_TEST),
    ("result of a done task", COORDINATOR,
     "  if (tasks_[index].state == State::kDone) return;\n  Task& task = tasks_[index];\n  if (!task.rec",
     "  Task& task = tasks_[index];\n  if (!task.rec", JOBS_TEST),
    ("recorded twice", COORDINATOR, "if (!task.recorded) commands_", "commands_", JOBS_TEST),
    ("done task stays with its worker", COORDINATOR,
     "  detach(index);\n  remove_ready(index);\n  Task& task = tasks_[index];\n  task.state = State::kDone;",
     "  remove_ready(index);\n  Task& task = tasks_[index];\n  task.state = State::kDone;", JOBS_TEST),
    ("done task stays ready", COORDINATOR,
     "  remove_ready(index);\n  Task& task = tasks_[index];\n  task.state = State::kDone;",
     "  Task& task = tasks_[index];\n  task.state = State::kDone;", JOBS_TEST),
    ("redone input makes running readers ready", COORDINATOR,
     "--next.missing == 0 && next.state == State::kWaiting", "--next.missing == 0", JOBS_TEST),
    ("let go for good", COORDINATOR, "  settings_.spared.erase(*task.key);\n", "", JOBS_TEST),
    ("readers do not wait for a bad input", COORDINATOR,
     "    if (next.state == State::kReady) release(dependent);\n", "", JOBS_TEST),
    ("done is announced once only", COORDINATOR, "  ++undone_;\n  announced_ = false;\n  for",
     "  ++undone_;\n  for", JOBS_TEST),
    ("late complaint takes a task away", COORDINATOR,
     "task.state == State::kAssigned && task.worker == event.worker",
     "task.state == State::kAssigned", JOBS_TEST),
    ("complaint about an input that is made already", COORDINATOR,
     "task.state == State::kDone || tasks_[input].state != State::kDone",
     "task.state == State::kDone", JOBS_TEST),
    ("a bad disk is tried for ever", COORDINATOR, "> kMostDistrust", "> 1000000", JOBS_TEST),
    ("failure of a done task", COORDINATOR,
     "index == kUnknown || tasks_[index].state == State::kDone) return;\n  release(index);\n  fail",
     "index == kUnknown) return;\n  release(index);\n  fail", JOBS_TEST),
    ("hands out after the end", COORDINATOR, "!stopped_ && !draining_", "!draining_", JOBS_TEST),
    ("hands out while draining", COORDINATOR, "!stopped_ && !draining_", "!stopped_", JOBS_TEST),
    ("drained with tasks running", COORDINATOR, "    if (ranks().busy > 0) return;\n", "", JOBS_TEST),
    ("done with tasks open", COORDINATOR, "announced_ || undone_ > 0", "announced_", JOBS_TEST),
    ("nobody is dismissed", COORDINATOR,
     "  for (const auto& [id, worker] : workers_) commands_.emplace_back(Dismiss{id, event.code});\n",
     "  (void)event;\n", JOBS_TEST),
    ("known content is not passed on", COORDINATOR, "    assignment.expected = known->second;\n", "",
     JOBS_TEST),
    ("a task twice on one worker", WORKER, "leaving_ || has(assignment.task.id)", "leaving_", JOBS_TEST),
    ("takes tasks after dismissal", WORKER, "leaving_ || has(assignment.task.id)",
     "has(assignment.task.id)", JOBS_TEST),
    ("starts what waited after dismissal", WORKER, "    waiting_.clear();\n    actions.emplace_back(Leave{dis",
     "    actions.emplace_back(Leave{dis", JOBS_TEST),
    ("waits for its coordinator for ever", WORKER, "now_ - heard_ > patience_seconds_", "false",
     JOBS_TEST),
    ("impatient from the first tick", WORKER, "  if (now_ == 0.0) heard_ = tick.now;\n", "", JOBS_TEST),
    ("heartbeats at every tick", WORKER, "tick.now - told_ < heartbeat_seconds_", "false", JOBS_TEST),
    ("a dropped task is reported", WORKER, "    case Outcome::Kind::kDropped:\n      break;",
     "    case Outcome::Kind::kDropped:\n      actions.emplace_back(Report{TaskFailed{id_, task, \"\", false}});\n"
     "      break;", JOBS_TEST),
    ("files are renamed before they are synced", STORE, "    file->sync();\n", "", FAULTS_TEST),
    ("folders are not synced", STORE,
     "  fs.sync_dir(path.parent_path().empty() ? Path(\".\") : path.parent_path());\n", "", FAULTS_TEST),
    ("failed writes leave temporaries", STORE, "      fs.remove(temporary);\n", "", STORE_TEST),
    ("what was written is not read back", STORE, "read.size() != bytes.size() ||", "read.empty() && !bytes.empty() && false &&",
     STORE_TEST),
    ("a torn line swallows the next", MANIFEST,
     "  if (!bytes.empty() && bytes.back() != std::byte{'\\n'}) file_->append(std::string_view(\"\\n\"));\n",
     "", STORE_TEST),
    ("damaged lines count", MANIFEST, "hash_text(text).hex() != line.substr(0, kDigestDigits)", "false",
     STORE_TEST),
    ("the old marker stays while results change", RESULTS,
     "      if (fs_.remove(file(kCompleteName))) fs_.sync_dir(folder_.path());\n", "", FAULTS_TEST),
    ("the old marker may come back", RESULTS,
     "if (fs_.remove(file(kCompleteName))) fs_.sync_dir(folder_.path());",
     "fs_.remove(file(kCompleteName));", FAULTS_TEST),
]


def run(*command, **options):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)


def must(*command):
    result = run(*command)
    if result.returncode != 0:
        sys.exit(f"mutants: {' '.join(map(str, command))} failed:\n{result.stdout[-3000:]}{result.stderr[-3000:]}")


def copy_sources():
    """Only what differs is written, so that little is built again."""
    listed = run("git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard").stdout
    names = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    for old in [p for p in COPY.rglob("*") if p.is_file() and str(p.relative_to(COPY)) not in names]:
        old.unlink()
    for name in names:
        source, target = ROOT / name, COPY / name
        if target.is_file() and target.read_bytes() == source.read_bytes():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)


def noticed(name, file, old, new, test, seconds):
    path = COPY / file
    text = path.read_text()
    if text.count(old) != 1:
        sys.exit(f"mutants: '{name}': its text is found {text.count(old)} times in {file}; mend the list")
    path.write_text(text.replace(old, new))
    try:
        built = run("cmake", "--build", BUILD, "--target", test)
        if built.returncode != 0:
            print(f"'{name}' does not compile; mend the list:\n{built.stdout[-3000:]}")
            return False
        try:
            ran = run(BUILD / "bin" / test, "--gtest_brief=1", timeout=PATIENCE * (seconds + 1),
                      env={**os.environ, "TMPDIR": str(BUILD / "tmp")})
            return ran.returncode != 0
        except subprocess.TimeoutExpired:
            return True
    finally:
        path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description="Breaks guards of the service and sees whether tests notice.")
    parser.add_argument("names", nargs="*", help="only mutants whose name contains one of these")
    parser.add_argument("--list", action="store_true", help="name them and do nothing")
    arguments = parser.parse_args()
    chosen = [m for m in MUTANTS if not arguments.names or any(n in m[0] for n in arguments.names)]
    if not chosen:
        sys.exit("mutants: no mutant's name contains that; --list shows them")
    if arguments.list:
        for name, file, _, _, test in chosen:
            print(f"{name:50} {file:34} {test}")
        return
    copy_sources()
    must("cmake", "-S", COPY, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
         "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DCMAKE_UNITY_BUILD=OFF")
    (BUILD / "tmp").mkdir(exist_ok=True)
    tests = sorted({m[4] for m in chosen})
    print(f"building {', '.join(tests)}", flush=True)
    must("cmake", "--build", BUILD, "--target", *tests)
    seconds = {}
    for test in tests:
        began = time.monotonic()
        must(BUILD / "bin" / test, "--gtest_brief=1")
        seconds[test] = time.monotonic() - began
    missed = []
    for mutant in chosen:
        seen = noticed(*mutant, seconds[mutant[4]])
        print(f"{'noticed' if seen else 'MISSED ':8} {mutant[0]}", flush=True)
        if not seen:
            missed.append(mutant[0])
    print(f"{len(chosen) - len(missed)} of {len(chosen)} noticed")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
