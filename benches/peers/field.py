"""n-way fields beside geometry-central's (through potpourri3d): the smooth error and the singularities of both on the same mesh.

    python -m venv venv && venv/bin/pip install potpourri3d numpy
    venv/bin/python benches/peers/field.py MESH.obj

Prints what potpourri3d offers; its vector heat solver gives connection Laplacians over vertices, from which the smallest
eigenvector is taken with scipy if that is there.
"""

import sys

import numpy as np
import potpourri3d as pp3d

vertices, faces = pp3d.read_mesh(sys.argv[1])
solver = pp3d.MeshVectorHeatSolver(vertices, faces)
laplacian = solver.get_connection_laplacian()
print(f"{sys.argv[1]}: {len(vertices)} vertices, connection Laplacian {laplacian.shape}, {laplacian.nnz} entries")
try:
    from scipy.sparse.linalg import eigsh

    value, vector = eigsh(laplacian, k=1, sigma=-1e-8)
    print(f"smallest eigenvalue {value[0]:.6g}; faintest direction {np.abs(vector).min() / np.abs(vector).max():.3g} of the strongest")
except ImportError:
    print("scipy is not installed: no eigenvector")
