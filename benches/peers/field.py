"""n-way fields by geometry-central's connection Laplacian (through potpourri3d), for `cargo bench --bench field` to measure.

    python -m venv venv && venv/bin/pip install potpourri3d scipy
    venv/bin/python benches/peers/field.py MESH.obj ...
    cargo bench --bench field -- MESH.obj ...

Writes `MESH.directions.json` beside each mesh: for n = 1, 2, 4, 6 the eigenvector of the smallest eigenvalue of the Laplacian of
n-way fields (Knoppel et al. 2013), found with scipy, and the seconds it took. Prints the seconds of that library's own
interactive solver as well: the first transport of a direction over the mesh, and one more after that.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import potpourri3d as pp3d
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

WAYS = [1, 2, 4, 6]


def smallest(laplacian, mass):
    """The eigenvector of the smallest eigenvalue by inverse iterations on one factorization."""
    n = laplacian.shape[0]
    factors = splu(csc_matrix(laplacian + 1e-8 * diags(mass)))
    x = np.random.default_rng(1).standard_normal(n) + 1j * np.random.default_rng(2).standard_normal(n)
    for _ in range(20):
        x = factors.solve(mass * x)
        x /= np.sqrt((mass * np.abs(x) ** 2).sum())
    return x


for file in sys.argv[1:]:
    vertices, faces = pp3d.read_mesh(file)
    used = np.unique(faces)
    number = np.full(len(vertices), -1)
    number[used] = np.arange(len(used))
    vertices, faces = vertices[used], number[faces]
    begin = time.time()
    solver = pp3d.MeshVectorHeatSolver(vertices, faces)
    solver.transport_tangent_vector(0, [1.0, 0.0])
    first = time.time() - begin
    begin = time.time()
    solver.transport_tangent_vectors([0, len(vertices) // 2], [[1.0, 0.0], [0.0, 1.0]])
    again = time.time() - begin
    print(f"{Path(file).name}: transport of one direction {first:.2f} s, of two after that {again:.3f} s")
    x_axis, y_axis, _ = solver.get_tangent_frames()
    base = solver.get_connection_laplacian().tocoo()
    mass = pp3d.vertex_areas(vertices, faces)
    fields = {}
    for n in WAYS:
        begin = time.time()
        apart = base.row != base.col
        size = np.abs(base.data)
        turned = np.where(apart, -size * (-base.data / np.maximum(size, 1e-300)) ** n, base.data)
        laplacian = csc_matrix((turned, (base.row, base.col)), shape=base.shape)
        power = smallest(laplacian, mass)
        angle = np.angle(power) / n
        directions = np.cos(angle)[:, None] * x_axis + np.sin(angle)[:, None] * y_axis
        fields[n] = [time.time() - begin, directions.tolist()]
    out = Path(file).with_suffix(".directions.json")
    out.write_text(json.dumps({"name": "geometry-central", "positions": vertices.astype(np.float32).tolist(), "fields": fields}))
