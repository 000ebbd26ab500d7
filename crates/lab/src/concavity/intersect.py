"""The solid within each hull: intersect.py MESH HULLS OUT, all OBJ. Needs manifold3d and numpy."""
import sys
import numpy as np
from manifold3d import Manifold, Mesh64

def read(path):
    """Vertices and faces of each object."""
    points, parts = [], [[]]
    for line in open(path):
        key, *words = line.split() or [""]
        if key == "v":
            points.append([float(word) for word in words[:3]])
        elif key == "o":
            parts.append([])
        elif key == "f":
            parts[-1].append([int(word) - 1 for word in words])
    return np.array(points), [np.array(part) for part in parts if part]

def solid(points, faces):
    """Vertices at the same place become one."""
    points, index = np.unique(points[faces.ravel()], axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    mesh = Mesh64(points, faces.astype(np.uint64))
    mesh.merge()
    made = Manifold(mesh)
    if "NoError" not in str(made.status()) or made.is_empty():
        sys.exit("error: no manifold: " + str(made.status()))
    if made.volume() < 0:
        made = Manifold(Mesh64(points, faces[:, ::-1].astype(np.uint64)))
    return made

points, (faces,) = read(sys.argv[1])
whole = solid(points, faces)
points, hulls = read(sys.argv[2])
with open(sys.argv[3], "w") as out:
    first = 1
    for number, faces in enumerate(hulls):
        hull = Manifold.hull_points(points[np.unique(faces)])
        part = (whole ^ hull).to_mesh64()
        out.write(f"o {number}\n")
        for point in part.vert_properties[:, :3]:
            out.write("v %r %r %r\n" % tuple(map(float, point)))
        for face in part.tri_verts:
            out.write("f %d %d %d\n" % tuple(int(vertex) + first for vertex in face))
        first += len(part.vert_properties)
