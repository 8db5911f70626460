#!/usr/bin/python3
"""Shows how to read a bake with h5py: everything is reached through BAKE_DIR/bake.h5.

    scripts/read_bake.py out/gallery

/STAGE/TASK is the artifact of one task: a group of datasets, each with `units` and `meaning`, whose
attributes are what the task measured; texts are UTF-8 bytes, nested values JSON text under
"json:NAME". Where the scene lies far from the world's origin, all positions are relative to the file's
own attribute "json:origin".
"""
import argparse
import json
import os
import sys

import h5py
import numpy as np

ESCAPED = 65535  # rays/*/distance of a ray that hits nothing


def artifacts(bake, stage):
    """Name and group of each artifact of a stage; those that the bake did not keep have no link."""
    for name in bake.get(stage, {}):
        yield name, bake[stage][name]


def quantised(artifact, name):
    """Integers with a scale per row, as numbers."""
    return artifact[name][...] * artifact[name + ".scale"][...][:, None]


def list_stages(bake):
    print(f"{'stage':<20}{'tasks':>7}  datasets")
    for stage in bake:
        tasks = list(artifacts(bake, stage))
        print(f"{stage:<20}{len(tasks):>7}  {', '.join(tasks[0][1]) if tasks else ''}")


def samples_per_cluster(bake):
    begin = bake["samples/samples/cluster_begin"]
    print(f"\n{begin[-1]} samples in {len(begin) - 1} clusters ({begin.attrs['meaning'].decode()}):")
    print(" ".join(str(n) for n in np.diff(begin[...].astype(int))))


def origin(bake):
    """World coordinates, m, of what all positions are relative to."""
    return np.array(json.loads(bake.attrs["json:origin"])) if "json:origin" in bake.attrs else np.zeros(3)


def bounds(bake):
    positions = bake["samples/samples/position"][...] + origin(bake)
    print(f"they lie from {positions.min(axis=0)} to {positions.max(axis=0)} m")


def error_per_stage(bake):
    print(f"\n{'stage':<20}{'mean error':>12}{'largest':>12}")
    for stage in bake:
        errors = [a.attrs["error"] for _, a in artifacts(bake, stage) if "error" in a.attrs]
        if errors:
            print(f"{stage:<20}{np.mean(errors):>12.5f}{np.max(errors):>12.5f}")


def depth_buffer(bake, cluster, sample):
    """Distances in m along each direction, as cast and as the visibility basis gives them back."""
    rays = bake[f"rays/{cluster:04d}"]
    visibility = bake[f"visibility/{cluster:04d}"]
    bound = rays.attrs["bound"]
    packed = rays["distance"][sample]
    cast = np.where(packed == ESCAPED, bound, (packed / 65534.0) ** 2 * bound)
    z = quantised(visibility, "mean")[0] + (
        quantised(visibility, "coefficients")[sample] @ quantised(visibility, "basis"))
    return cast, np.clip(z, 0, 1) ** 2 * bound


def show_depth_buffer(bake):
    if "rays" not in bake or "visibility" not in bake:
        return
    # A cluster that sees everything up to its walls has no depths.
    with_depths = [c for c, name in enumerate(sorted(bake["visibility"]))
                   if len(quantised(bake[f"visibility/{name}"], "mean"))]
    if not with_depths:
        print("\nno cluster needs depth buffers: all see everything up to their walls")
        return
    cluster = with_depths[0]
    cast, again = depth_buffer(bake, cluster, sample=0)
    rms = np.sqrt(np.mean((again - cast) ** 2))
    print(f"\ncluster {cluster}, sample 0: {len(cast)} distances, median {np.median(cast):.3f} m, "
          f"rms error of the reconstruction {rms:.3f} m")


def main():
    parser = argparse.ArgumentParser(description="Reads a bake with h5py.")
    parser.add_argument("bake", help="folder that prt_bake wrote to")
    index = os.path.join(parser.parse_args().bake, "bake.h5")
    if not os.path.isfile(index):
        sys.exit(f"{index}: there is none; a finished bake has it")
    with h5py.File(index, "r") as bake:
        list_stages(bake)
        samples_per_cluster(bake)
        bounds(bake)
        error_per_stage(bake)
        show_depth_buffer(bake)


if __name__ == "__main__":
    main()
