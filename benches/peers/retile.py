"""Re-tiling beside other people's tools: evenness and distance, in one run.

    python -m venv venv && venv/bin/pip install pymeshlab pyacvd pyvista
    venv/bin/python benches/peers/retile.py PATH/TO/lapped MESH.obj ...

Each mesh is brought to its own number of vertices by `lapped retile`, PyMeshLab's isotropic remeshing (its edge length
searched so that the count comes out) and pyacvd. Distances are PyMeshLab's, both ways, in mean edges.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyacvd
import pymeshlab
import pyvista


def evenness(points, faces):
    edges = np.unique(np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    corners = points[faces]
    least = np.full(len(faces), 180.0)
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1)))
        least = np.minimum(least, angle)
    valence = np.bincount(edges.ravel(), minlength=len(points))
    return lengths.mean(), lengths.std() / lengths.mean(), least.min(), np.percentile(least, 5), (valence == 6).mean()


def distance(original, points, faces):
    made = pymeshlab.MeshSet()
    made.load_new_mesh(str(original))
    made.add_mesh(pymeshlab.Mesh(points, faces))
    far = []
    for a, b in [(0, 1), (1, 0)]:
        far.append(made.get_hausdorff_distance(sampledmesh=a, targetmesh=b, samplevert=True, sampleface=True, samplenum=50_000)["max"])
    return max(far)


def by_lapped(program, mesh, count):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.ply"
        subprocess.run([program, "retile", mesh, "--vertices", str(count), "-o", out, "--quiet"], check=True)
        made = pymeshlab.MeshSet()
        made.load_new_mesh(str(out))
        return made.current_mesh().vertex_matrix(), made.current_mesh().face_matrix()


def by_meshlab(mesh, count):
    made = pymeshlab.MeshSet()
    made.load_new_mesh(str(mesh))
    area = made.get_geometric_measures()["surface_area"]
    edge = (2 * area / (3**0.5 * count)) ** 0.5
    for _ in range(4):
        made = pymeshlab.MeshSet()
        made.load_new_mesh(str(mesh))
        made.meshing_isotropic_explicit_remeshing(iterations=10, targetlen=pymeshlab.PureValue(edge))
        found = made.current_mesh().vertex_number()
        if abs(found - count) < 0.01 * count:
            break
        edge *= (found / count) ** 0.5
    return made.current_mesh().vertex_matrix(), made.current_mesh().face_matrix()


def by_acvd(mesh, count):
    surface = pyvista.read(mesh).extract_surface().triangulate().clean()
    clusters = pyacvd.Clustering(surface)
    while clusters.mesh.n_points < 12 * count:
        clusters.subdivide(2)
    clusters.cluster(count)
    made = clusters.create_mesh()
    return np.asarray(made.points, float), made.faces.reshape(-1, 4)[:, 1:]


def main():
    program, meshes = sys.argv[1], sys.argv[2:]
    print(f"{'mesh':20} {'tool':10} {'vertices':>9} {'std/mean':>8} {'least':>6} {'5 %':>6} {'six':>5} {'far/e':>6} {'secs':>6}")
    for mesh in meshes:
        start = pymeshlab.MeshSet()
        start.load_new_mesh(mesh)
        start.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(0))
        count = start.current_mesh().vertex_number()
        tools = [("lapped", lambda: by_lapped(program, mesh, count)), ("meshlab", lambda: by_meshlab(mesh, count)), ("acvd", lambda: by_acvd(mesh, count))]
        for name, run in tools:
            begin = time.time()
            try:
                points, faces = run()
            except Exception as problem:
                print(f"{Path(mesh).name:20} {name:10} {problem}")
                continue
            seconds = time.time() - begin
            edge, variation, least, low, six = evenness(points, faces)
            far = distance(mesh, points, faces) / edge
            print(f"{Path(mesh).name:20} {name:10} {len(points):9} {variation:8.3f} {least:6.1f} {low:6.1f} {six:5.2f} {far:6.2f} {seconds:6.2f}", flush=True)


if __name__ == "__main__":
    main()
