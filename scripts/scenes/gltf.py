# SPDX-License-Identifier: Apache-2.0
"""A glTF 2.0 file in the making: materials, meshes, nodes, lights, a camera, an animation.

Computed numbers are rounded to multiples of 2^-16, so that the same bytes come out on every
machine. The binary data is in the file itself.
"""

import base64

import numpy as np

FLOAT, SHORT, INT = 5126, 5123, 5125  # component types
VERTICES, INDICES = 34962, 34963  # targets of buffer views
SHORTS = 65535  # vertices that 16 bits number


def rounded(values):
    """Multiples of 2^-16."""
    return np.round(np.asarray(values, dtype=np.float64) * 65536) / 65536 + 0.0


def about(axis, degrees):
    """The quaternion of a turn about an axis of length 1."""
    half = np.radians(degrees) / 2
    return rounded([*(np.asarray(axis) * np.sin(half)), np.cos(half)]).tolist()


def looking(direction, up=(0, 1, 0)):
    """The quaternion that turns -z, where cameras and lights look, to a direction."""
    back = -np.asarray(direction, dtype=np.float64)
    back /= np.linalg.norm(back)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    m = np.stack([right, np.cross(back, right), back], axis=1)
    # The largest component first, so that nothing is divided by a small number.
    squares = [m[0, 0], m[1, 1], m[2, 2], m.trace()]
    k = int(np.argmax(squares))
    q = np.empty(4)
    if k == 3:
        q[:3] = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
        q[3] = 1 + m.trace()
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        q[k] = 1 + m[k, k] - m[i, i] - m[j, j]
        q[i], q[j], q[3] = m[i, k] + m[k, i], m[j, k] + m[k, j], m[j, i] - m[i, j]
    return rounded(q / np.linalg.norm(q)).tolist()


class Gltf:
    """The parts of one file; `document` is its JSON."""

    def __init__(self, name):
        self.name = name
        self.nodes, self.cameras, self.materials, self.meshes = [], [], [], []
        self.accessors, self.views, self.lights, self.animations = [], [], [], []
        self._data = b""
        self._extensions = set()
        self._children = set()

    def _array(self, array, target=None, **fields):
        """An accessor of an array, and its number."""
        self._data += b"\0" * (-len(self._data) % 4)
        raw = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(raw)}
        self.views.append(view | ({"target": target} if target else {}))
        accessor = {"bufferView": len(self.views) - 1, "count": len(array)}
        self.accessors.append(accessor | fields)
        self._data += raw
        return len(self.accessors) - 1

    def material(self, name, colour, metal=0.0, rough=1.0, emissive=None, strength=1.0, glass=None):
        """A material; `glass` is the index of refraction of one that lets all light through."""
        factors = {"baseColorFactor": [*colour, 1.0], "metallicFactor": metal}
        factors["roughnessFactor"] = rough
        material = {"name": name, "pbrMetallicRoughness": factors, "doubleSided": True}
        more = {}
        if emissive:
            material["emissiveFactor"] = emissive
            more["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        if glass:
            more["KHR_materials_transmission"] = {"transmissionFactor": 1.0}
            more["KHR_materials_ior"] = {"ior": glass}
        if more:
            material["extensions"] = more
        self._extensions |= set(more)
        self.materials.append(material)
        return len(self.materials) - 1

    def mesh(self, name, *parts):
        """A mesh of (shape, material) pairs."""
        primitives = []
        for (vertices, triangles), material in parts:
            points = rounded(vertices).astype("<f4")
            primitives.append(self._primitive(points, np.asarray(triangles), material))
        self.meshes.append({"name": name, "primitives": primitives})
        return len(self.meshes) - 1

    def _primitive(self, points, triangles, material):
        low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        fields = {"componentType": FLOAT, "type": "VEC3", "min": low, "max": high}
        position = self._array(points, VERTICES, **fields)
        kind, number = (SHORT, "<u2") if len(points) <= SHORTS else (INT, "<u4")
        indices = triangles.reshape(-1).astype(number)
        index = self._array(indices, INDICES, componentType=kind, type="SCALAR")
        return {"attributes": {"POSITION": position}, "indices": index, "material": material}

    def quads(self, name, quads, material):
        """A mesh of quads whose corners are exact, and its node."""
        points = np.array(quads, dtype=np.float64).reshape(-1, 3).astype("<f4")
        corners = np.array([0, 1, 2, 0, 2, 3])
        indices = np.concatenate([4 * i + corners for i in range(len(quads))])
        primitives = [self._primitive(points, indices, material)]
        self.meshes.append({"name": name, "primitives": primitives})
        return self.node(name, mesh=len(self.meshes) - 1)

    def node(self, name, at=None, size=None, children=(), **fields):
        """A node, and its number; it stands in the scene, or below the node whose child it is."""
        node = {"name": name, **fields}
        if at is not None:
            node["translation"] = rounded(at).tolist()
        if size is not None:
            node["scale"] = rounded(np.broadcast_to(size, 3)).tolist()
        if children:
            node["children"] = list(children)
            self._children |= set(children)
        self.nodes.append(node)
        return len(self.nodes) - 1

    def put(self, name, *parts, **fields):
        """A mesh of (shape, material) pairs and its node."""
        return self.node(name, mesh=self.mesh(name, *parts), **fields)

    def camera(self, eye, target, yfov, aspect=1.0):
        """The camera, by a point that it looks at and its angle in degrees."""
        view = {"yfov": float(rounded(np.radians(yfov))), "aspectRatio": aspect, "znear": 0.01}
        self.cameras.append({"type": "perspective", "perspective": view})
        turn = looking(np.subtract(target, eye))
        self.node("camera", at=eye, camera=len(self.cameras) - 1, rotation=turn)

    def sun(self, direction, colour, intensity):
        """A directional light."""
        self._extensions.add("KHR_lights_punctual")
        light = {"name": "sun", "type": "directional", "color": colour, "intensity": intensity}
        self.lights.append(light)
        reference = {"KHR_lights_punctual": {"light": len(self.lights) - 1}}
        self.node("sun", rotation=looking(direction), extensions=reference)

    def animation(self, name, *channels):
        """An animation of (node, path, times, values) channels, straight between their keys."""
        samplers, targets = [], []
        for node, path, times, values in channels:
            keys = rounded(times).astype("<f4")
            span = {"min": [float(keys[0])], "max": [float(keys[-1])]}
            number = self._array(keys, componentType=FLOAT, type="SCALAR", **span)
            values = rounded(values).astype("<f4")
            kind = {3: "VEC3", 4: "VEC4"}[values.shape[1]]
            output = self._array(values, componentType=FLOAT, type=kind)
            samplers.append({"input": number, "output": output, "interpolation": "LINEAR"})
            target = {"node": node, "path": path}
            targets.append({"sampler": len(samplers) - 1, "target": target})
        self.animations.append({"name": name, "channels": targets, "samplers": samplers})

    def document(self):
        """The file as an object; parts without anything in them are left out."""
        roots = [k for k in range(len(self.nodes)) if k not in self._children]
        lights = {"KHR_lights_punctual": {"lights": self.lights}} if self.lights else None
        uri = "data:application/octet-stream;base64," + base64.b64encode(self._data).decode()
        parts = {
            "asset": {"version": "2.0", "generator": "scripts/make_scenes.py"},
            "extensionsUsed": sorted(self._extensions),
            "extensions": lights,
            "scene": 0,
            "scenes": [{"name": self.name, "nodes": roots}],
            "nodes": self.nodes,
            "cameras": self.cameras,
            "materials": self.materials,
            "meshes": self.meshes,
            "animations": self.animations,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self._data), "uri": uri}],
        }
        return {name: part for name, part in parts.items() if part not in (None, [])}
