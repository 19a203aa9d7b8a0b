"""Unwrapping beside xatlas: seconds, charts, stretch and packing, in one run.

    python -m venv venv && venv/bin/pip install xatlas numpy
    cargo bench --bench bake --no-run
    LAPPED_CORPUS=PATH/TO/CORPUS venv/bin/python benches/peers/unwrap.py NAME ...

Each mesh of the corpus whose name contains one of the NAMEs is unwrapped and packed on 1024 texels with 2 texels of padding, by
`lapped` (through the bench `bake`, both kinds of charts) and by xatlas with its default options. Stretch is that of Sander et al.
2001, computed here for xatlas by the same formula as in `src/atlas/measure.rs`; vertices at equal positions are welded first, as
both do.
"""

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import xatlas


def read(path):
    """Positions and triangles of an OBJ or a binary PLY of triangles."""
    if path.suffix == ".obj":
        points, faces = [], []
        for line in path.read_text().splitlines():
            word = line.split()
            if word[:1] == ["v"]:
                points.append([float(x) for x in word[1:4]])
            elif word[:1] == ["f"]:
                corner = [int(w.split("/")[0]) for w in word[1:]]
                corner = [c - 1 if c > 0 else len(points) + c for c in corner]
                faces += [[corner[0], corner[k], corner[k + 1]] for k in range(1, len(corner) - 1)]
        return np.array(points, np.float32), np.array(faces, np.uint32)
    data = path.read_bytes()
    head, body = data[: data.index(b"end_header\n")].decode(), data[data.index(b"end_header\n") + 11 :]
    count = {line.split()[1]: int(line.split()[2]) for line in head.splitlines() if line.startswith("element")}
    points = np.frombuffer(body, "<f4", 3 * count["vertex"]).reshape(-1, 3)
    faces = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<i4", 3)]), count["face"], points.nbytes)
    return points.copy(), faces["v"].astype(np.uint32)


def weld(points, faces):
    points, index = np.unique(points, axis=0, return_inverse=True)
    faces = index.reshape(-1)[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points, faces[whole].astype(np.uint32)


def stretch(p, uv, size):
    """L2 and Linf of faces with corners p (n, 3, 3) at uv (n, 3, 2), and the filled share of size texels."""
    p, uv = p.astype(float), uv.astype(float)
    double = np.cross(uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0])
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    ok = np.abs(double) > 1e-12
    p, uv, double, area = p[ok], uv[ok], double[ok], area[ok]
    (u, v) = uv[:, :, 0], uv[:, :, 1]
    along_u = (p[:, 0] * (v[:, 1] - v[:, 2])[:, None] + p[:, 1] * (v[:, 2] - v[:, 0])[:, None] + p[:, 2] * (v[:, 0] - v[:, 1])[:, None]) / double[:, None]
    along_v = (p[:, 0] * (u[:, 2] - u[:, 1])[:, None] + p[:, 1] * (u[:, 0] - u[:, 2])[:, None] + p[:, 2] * (u[:, 1] - u[:, 0])[:, None]) / double[:, None]
    a, b, c = (along_u**2).sum(1), (along_u * along_v).sum(1), (along_v**2).sum(1)
    texels = 0.5 * np.abs(double)
    even = (texels.sum() / area.sum()) ** 0.5
    l2 = ((0.5 * (a + c) * area).sum() / area.sum()) ** 0.5 * even
    linf = (0.5 * (a + c + ((a - c) ** 2 + 4 * b**2) ** 0.5)).max() ** 0.5 * even
    return l2, linf, texels.sum() / size


def by_xatlas(path):
    points, faces = weld(*read(path))
    before, begin = resource.getrusage(resource.RUSAGE_SELF), time.time()
    atlas = xatlas.Atlas()
    atlas.add_mesh(points, faces)
    pack = xatlas.PackOptions()
    pack.resolution, pack.padding, pack.bruteForce = 1024, 2, False
    atlas.generate(xatlas.ChartOptions(), pack, False)
    seconds, after = time.time() - begin, resource.getrusage(resource.RUSAGE_SELF)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    _, indices, uv = atlas[0]
    uv = uv * np.array([atlas.width, atlas.height])
    l2, linf, _ = stretch(points[faces], uv[indices], 1)
    # Pages of the resolution asked for; charts may spill over to further ones.
    return f"{path.name:20} {len(faces):>7} xatlas| {seconds:>7.2f} {processor:>7.2f} | {atlas.chart_count:>6} {100 * atlas.utilization:>5.1f} {l2:>7.4f} {linf:>7.2f}  ({atlas.width} x {atlas.height}, {atlas.atlas_count} pages)"


def main():
    folder = Path(os.environ["LAPPED_CORPUS"]) / "meshes"
    for path in sorted(folder.iterdir()):
        if not any(name in path.name for name in sys.argv[1:]):
            continue
        run = subprocess.run(["cargo", "bench", "-q", "--bench", "bake", "--", path.name], capture_output=True, text=True, check=True)
        print("\n".join(line for line in run.stdout.splitlines() if "|" in line and "secs" not in line), flush=True)
        if path.suffix in (".obj", ".ply"):
            print(by_xatlas(path), flush=True)


if __name__ == "__main__":
    print("mesh                   faces how   |    secs processor | charts fill%      L2    Linf needles")
    main()
