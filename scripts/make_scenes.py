#!/usr/bin/python3
"""Makes the scenes under configs/scenes. Needs Debian's python3-numpy.

    scripts/make_scenes.py            writes all of them
    scripts/make_scenes.py --out DIR --triangles 2000000 large_room
    scripts/make_scenes.py --check    fails unless the files are what this script makes
"""

import argparse
import pathlib
import sys

from scenes.cornell import closed_box, cornell, large_room, textured_room
from scenes.courtyard import courtyard
from scenes.gallery import gallery
from scenes.house import house

SCENES = {"cornell": cornell, "gallery": gallery, "closed_box": closed_box,
          "textured_room": textured_room, "courtyard": courtyard}
# Too large for a repository: made only by name.
LARGE = {"large_room": large_room, "house": house}
FOLDER = pathlib.Path(__file__).resolve().parent.parent / "configs" / "scenes"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="SCENE", help=", ".join(SCENES | LARGE))
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--out", type=pathlib.Path, default=FOLDER, help="folder to write to")
    parser.add_argument("--albedo", type=float, default=0.5, help="of closed_box")
    parser.add_argument("--triangles", type=int, default=1_000_000, help="of large_room")
    parser.add_argument("--rooms", type=int, default=12, help="of house, along each side")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(SCENES | LARGE))
    if unknown:
        parser.error(f"no scene {unknown[0]}: there are {', '.join(SCENES | LARGE)}")

    wrong = []
    for name in arguments.names or SCENES:
        if name == "closed_box":
            glb = closed_box(arguments.albedo)
        elif name in LARGE:
            glb = LARGE[name](arguments.rooms if name == "house" else arguments.triangles)
        else:
            glb = SCENES[name]()
        data, path = glb.bytes(), arguments.out / f"{name}.glb"
        if arguments.check:
            if not path.is_file() or path.read_bytes() != data:
                wrong.append(path)
            continue
        arguments.out.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        print(f"{path}: {glb.triangles()} triangles, {len(data)} bytes")
    for path in wrong:
        print(f"{path} is not what {sys.argv[0]} makes: run it and commit the result",
              file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
