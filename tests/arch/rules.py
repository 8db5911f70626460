"""The rules of the architecture, each a function from a tree of files to complaints.

A tree is a dictionary from a file's path (relative to the repository, with /) to its bytes.
"""

import re

MOST_LINES = 499  # of a source file: beyond, it wants splitting
MOST_BYTES = 1 << 20  # of any file: a repository is no store of results

# module: the modules whose headers it may include beside its own (CONTRIBUTING.md says why).
MODULES = {
    "base": "",
    "scene": "base",
    "domains": "base scene",
    "bases": "base domains",
    "operators": "base bases",
    "transport": "base scene domains bases operators",
    "store": "base domains bases operators",
    "jobs": "base",
    "package": "base scene domains bases operators",
    "player": "base scene domains bases operators package",
    "methods": "base scene domains bases operators transport store jobs package",
    "evaluate": "base scene domains transport package player",
    "apps": "base scene domains bases operators transport store jobs package player methods evaluate",
}
MODULES = {name: set(allowed.split()) for name, allowed in MODULES.items()}

# Single headers that a module may include although it may not use their module.
SINGLE_HEADERS = {
    "evaluate": {"store/artifact.h", "methods/method.h", "methods/options.h", "jobs/task.h",
                 "methods/common/inputs.h"},
}

# Folders that only some places may include from: (folder, places).
GUARDED_FOLDERS = [
    ("scene/embree/", ("src/scene/embree/", "src/apps/", "tests/")),
    ("jobs/mpi/", ("src/jobs/mpi/", "src/apps/", "tests/")),
    ("methods/lb/", ("src/methods/", "tests/")),
    ("player/gl/", ("src/player/gl/", "src/apps/", "tests/")),
]

# Third-party headers and the place, or the places, that may include them.
THIRD_PARTY = [
    (r"embree[34]?/", "src/scene/embree/"),
    (r"mpi\.h", "src/jobs/mpi/"),
    (r"hdf5|H5\w*public\.h", "src/store/"),
    (r"CLI/", "src/apps/"),
    (r"yaml-cpp/", "src/apps/"),
    (r"tiny_gltf\.h", "src/scene/"),
    (r"Imf|Imath|Iex|OpenEXR/", ("src/scene/exr_image.cpp", "src/base/image_file.cpp")),
    (r"epoxy/|EGL/|GL/|GLFW/|imgui", "src/player/gl/"),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">]', re.M)
# Spelled in two parts, so that this file keeps its own rules.
UNFINISHED = re.compile(rb"\b(TO" rb"DO|FIX" rb"ME|XX" rb"X)\b")
MACHINE_PATH = re.compile(rb"(?<![\w.$}~-])/(wo" rb"rk|ho" rb"me|Use" rb"rs|ro" rb"ot)/")
TEXT_SUFFIXES = (".h", ".cpp", ".py", ".cmake", ".txt", ".md", ".yaml", ".json", ".sh")


def is_source(path):
    return path.startswith(("src/", "tests/", "cmake/", "examples/")) and path.endswith((".h", ".cpp"))


def is_text(path):
    return path.endswith(TEXT_SUFFIXES) or "." not in path.rsplit("/", 1)[-1]


def includes(data):
    """(is quoted, header) of every include directive."""
    return [(m[1] == '"', m[2]) for m in INCLUDE.finditer(data.decode("utf-8", "replace"))]


def module_directions(tree):
    """A module includes headers of the modules it may use, and of no others."""
    for path, data in tree.items():
        if not (path.startswith("src/") and is_source(path)):
            continue
        module = path.split("/")[1]
        if module not in MODULES:
            yield f"{path}: no module {module} is known; name it and what it may use in tests/arch/rules.py"
            continue
        allowed = MODULES[module] | {module}
        for quoted, header in includes(data):
            target = header.split("/")[0]
            if quoted and header in SINGLE_HEADERS.get(module, ()):
                continue
            if quoted and target not in allowed:
                yield f"{path}: {module} may not include {header}"


def guarded_folders(tree):
    """Implementations behind an interface are named only where they are wired in."""
    for path, data in tree.items():
        if not is_source(path):
            continue
        for _, header in includes(data):
            for folder, places in GUARDED_FOLDERS:
                if header.startswith(folder) and not path.startswith(places):
                    yield f"{path}: {header} may be included from {' and '.join(places)} only"


def third_party(tree):
    """Each library with a place of its own is included there alone."""
    for path, data in tree.items():
        if not is_source(path) or path.startswith("tests/"):
            continue
        for _, header in includes(data):
            for pattern, place in THIRD_PARTY:
                if re.match(pattern, header) and not path.startswith(place):
                    places = place if isinstance(place, str) else " and ".join(place)
                    yield f"{path}: {header} may be included from {places} only"


def file_lengths(tree):
    for path, data in tree.items():
        lines = data.count(b"\n")
        if (is_source(path) or path.startswith("scripts/")) and lines > MOST_LINES:
            yield f"{path}: {lines} lines are more than {MOST_LINES}; split it"


def file_sizes(tree):
    for path, data in tree.items():
        if len(data) >= MOST_BYTES:
            yield f"{path}: {len(data)} bytes; files stay below {MOST_BYTES}"


def include_guards(tree):
    for path, data in tree.items():
        if is_source(path) and path.endswith(".h") and b"\n#pragma once\n" not in b"\n" + data:
            yield f"{path}: no #pragma once"


def finished_words(tree):
    for path, data in tree.items():
        match = UNFINISHED.search(data) if is_text(path) else None
        if match:
            yield f"{path}: {match[0].decode()}: finish it or open an issue"


def portable_paths(tree):
    for path, data in tree.items():
        match = MACHINE_PATH.search(data) if is_text(path) else None
        if match:
            yield f"{path}: a path of one machine, {match[0].decode()}"


RULES = [module_directions, guarded_folders, third_party, file_lengths, file_sizes, include_guards,
         finished_words, portable_paths]
