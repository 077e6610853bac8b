# SPDX-License-Identifier: Apache-2.0
"""Bytes of a PLY file."""

import numpy as np


def ply_bytes(vertices, triangles, materials=None):
    """Binary PLY of float32 vertices and int32 triangles, with a material id a face when given."""
    faces = [("n", "u1"), ("v", "<i4", 3)] + ([("m", "<u2")] if materials is not None else [])
    array = np.empty(len(triangles), dtype=faces)
    array["n"] = 3
    array["v"] = triangles
    if materials is not None:
        array["m"] = materials
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\n"
        "property list uchar int vertex_indices\n"
        + ("property ushort material\n" if materials is not None else "")
        + "end_header\n"
    )
    return header.encode() + np.asarray(vertices, dtype="<f4").tobytes() + array.tobytes()
