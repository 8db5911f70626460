#!/usr/bin/python3
"""Checks the repository against tests/arch/rules.py; --self-test checks that each rule can fail."""

import pathlib
import subprocess
import sys

import rules

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
NOT_OURS = {".git", "build", "out", "shared", "__pycache__"}


def tracked_files():
    """Paths git tracks; without git or a checkout, all files but what building leaves."""
    listing = subprocess.run(
        ["git", "-c", f"safe.directory={ROOT}", "-C", str(ROOT), "ls-files", "-z"],
        capture_output=True, check=False) if (ROOT / ".git").exists() else None
    if listing and listing.returncode == 0:
        paths = [p for p in listing.stdout.decode().split("\0") if p]
    else:
        paths = [p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*")
                 if not NOT_OURS & set(p.relative_to(ROOT).parts)]
    return [p for p in paths if (ROOT / p).is_file()]


def complaints(tree):
    return [line for rule in rules.RULES for line in rule(tree)]


def self_test():
    """One tree per rule that breaks it alone, beside a sound one that breaks none."""
    sound = {
        "src/base/error.h": b"// Errors.\n#pragma once\n#include <string>\n",
        "src/scene/scene.cpp": b'#include "scene/scene.h"\n#include "base/error.h"\n',
        "src/scene/load.cpp": b"#include <tiny_gltf.h>\n",
        "src/scene/embree/caster.cpp": b"#include <embree3/rtcore.h>\n",
        "src/jobs/mpi/ranks.cpp": b"#include <mpi.h>\n",
        "src/store/hdf5.cpp": b"#include <hdf5.h>\n",
        "src/evaluate/error.cpp": b'#include "jobs/task.h"\n',
        "src/apps/main.cpp": b'#include "scene/embree/caster.h"\n#include <CLI/CLI.hpp>\n',
        "README.md": b"Builds into build/release; see https://example.org/ho" b"me/page\n",
    }
    broken = [
        (rules.module_directions, "src/scene/a.cpp", b'#include "player/player.h"\n'),
        (rules.module_directions, "src/evaluate/a.cpp", b'  #  include "jobs/coordinator.h"\n'),
        (rules.module_directions, "src/novel/a.cpp", b"int a;\n"),
        (rules.guarded_folders, "src/methods/a.cpp", b'#include "jobs/mpi/mpi_ranks.h"\n'),
        (rules.guarded_folders, "src/apps/a.cpp", b'#include "methods/lb/lb.h"\n'),
        (rules.third_party, "src/scene/a.cpp", b"#include <embree3/rtcore.h>\n"),
        (rules.third_party, "src/jobs/a.cpp", b"#include <mpi.h>\n"),
        (rules.third_party, "src/package/a.cpp", b"#include <hdf5.h>\n"),
        (rules.third_party, "src/methods/a.cpp", b"#include <yaml-cpp/yaml.h>\n"),
        (rules.third_party, "src/base/a.cpp", b"#include <CLI/CLI.hpp>\n"),
        (rules.third_party, "src/package/a.cpp", b"#include <tiny_gltf.h>\n"),
        (rules.third_party, "src/player/a.cpp", b"#include <epoxy/gl.h>\n"),
        (rules.third_party, "src/apps/a.cpp", b"#include <imgui.h>\n"),
        (rules.guarded_folders, "src/player/a.cpp", b'#include "player/gl/renderer.h"\n'),
        (rules.file_lengths, "src/base/a.cpp", b"\n" * (rules.MOST_LINES + 1)),
        (rules.file_sizes, "docs/a.png", b"\0" * rules.MOST_BYTES),
        (rules.include_guards, "src/base/a.h", b"int a;\n"),
        (rules.finished_words, "src/base/a.cpp", b"// TO" b"DO: all of it\n"),
        (rules.portable_paths, "scripts/run", b"cd /ho" b"me/me/prt\n"),
    ]
    failures = [f"sound tree: {line}" for line in complaints(sound)]
    for rule, path, data in broken:
        found = {r.__name__ for r in rules.RULES if list(r({**sound, path: data}))}
        if found != {rule.__name__}:
            failures.append(f"{path} {data[:40]}: {sorted(found)} spoke instead of {rule.__name__}")
    return failures


def main():
    if "--self-test" in sys.argv[1:]:
        found = self_test()
    else:
        found = complaints({p: (ROOT / p).read_bytes() for p in tracked_files()})
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
