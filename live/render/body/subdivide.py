"""Catmull-Clark subdivision of closed meshes of quadrilaterals (Catmull and Clark 1978), for any vertex data."""

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


def subdivide(values: Float64, faces: Int64) -> tuple[Float64, Int64]:
    """Each face becomes four; `values` (V, C) are positions and whatever else the vertices carry.

    Returns the new values, old vertices first, and the new faces (4F, 4) in the same turning sense.
    Raises ValueError if the mesh is not closed (an edge with other than two faces).
    """
    count = len(values)
    start, stop = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    pairs = np.stack([np.minimum(start, stop), np.maximum(start, stop)], axis=1)
    edges, edge_of = np.unique(pairs, axis=0, return_inverse=True)
    edge_of = edge_of.reshape(faces.shape)
    uses = np.bincount(edge_of.ravel(), minlength=len(edges))
    if not np.all(uses == 2):
        raise ValueError(f"the mesh is not closed: {int((uses != 2).sum())} edges without exactly two faces")

    face_value = values[faces].mean(axis=1)
    edge_faces = np.zeros((len(edges), values.shape[1]))
    np.add.at(edge_faces, edge_of.ravel(), np.repeat(face_value, 4, axis=0))
    middle = values[edges].mean(axis=1)
    edge_value = 0.5 * middle + 0.25 * edge_faces

    valence = np.bincount(edges.ravel(), minlength=count)[:, None].astype(np.float64)
    face_sum = np.zeros_like(values)
    np.add.at(face_sum, faces.ravel(), np.repeat(face_value, 4, axis=0))
    edge_sum = np.zeros_like(values)
    np.add.at(edge_sum, edges.ravel(), np.repeat(middle, 2, axis=0))
    vertex_value = (face_sum / valence + 2.0 * edge_sum / valence + (valence - 3.0) * values) / valence

    edge_index = count + edge_of
    centre = count + len(edges) + np.arange(len(faces))
    quads = [np.stack([faces[:, i], edge_index[:, i], centre, edge_index[:, i - 1]], axis=1) for i in range(4)]
    return np.concatenate([vertex_value, edge_value, face_value]), np.concatenate(quads)
