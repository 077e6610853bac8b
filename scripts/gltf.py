# SPDX-License-Identifier: Apache-2.0
"""glTF 2.0 objects with their data inside: nodes with a mesh each, a camera, lights, keys."""

import base64
import math
from typing import Any

import numpy as np

TRANSMISSION = "KHR_materials_transmission"
STRENGTH = "KHR_materials_emissive_strength"
LIGHTS = "KHR_lights_punctual"
FLOAT, UINT16, UINT32 = 5126, 5123, 5125
ARRAY, ELEMENTS = 34962, 34963
# Of the members of the file.
ORDER = [
    "asset",
    "extensionsUsed",
    "extensions",
    "scene",
    "scenes",
    "nodes",
    "cameras",
    "materials",
]
ORDER += ["meshes", "accessors", "bufferViews", "animations", "buffers"]


def material(
    name: str,
    colour: list[float],
    *,
    metallic: float = 0.0,
    roughness: float = 1.0,
    transmission: float = 0.0,
    emissive: list[float] | None = None,
    strength: float = 1.0,
) -> dict[str, Any]:
    """A metallic-roughness material; `emissive` is its light, `strength` the factor of that."""
    out: dict[str, Any] = {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*colour, 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        },
        "doubleSided": True,
    }
    extensions: dict[str, Any] = {}
    if emissive:
        out["emissiveFactor"] = emissive
        extensions[STRENGTH] = {"emissiveStrength": strength}
    if transmission:
        extensions[TRANSMISSION] = {"transmissionFactor": transmission}
    if extensions:
        out["extensions"] = extensions
    return out


def turned(axis: list[float], degrees: float) -> list[float]:
    """The quaternion x y z w of a turn, to 2^-24."""
    half = math.radians(degrees) / 2
    values = [*(math.sin(half) * a for a in axis), math.cos(half)]
    return [round(v * 2**24) / 2**24 for v in values]


class Gltf:
    """Collects a scene; `json()` is the object."""

    def __init__(self, name: str, materials: list[dict[str, Any]]):
        self._data = b""
        self._json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "scripts/make_scenes.py"},
            "scene": 0,
            "scenes": [{"name": name, "nodes": []}],
            "nodes": [],
            "materials": materials,
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }
        self._extensions = {e for m in materials for e in m.get("extensions", {})}

    def _add(self, array: np.ndarray, target: int | None, **fields: Any) -> int:
        """An accessor of an array in a view of its own."""
        self._data += b"\0" * (-len(self._data) % 4)
        raw = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(raw)}
        self._json["bufferViews"].append(view | ({"target": target} if target else {}))
        self._json["accessors"].append(
            {"bufferView": len(self._json["bufferViews"]) - 1, "count": len(array), **fields}
        )
        self._data += raw
        return len(self._json["accessors"]) - 1

    def node(self, name: str, parent: int | None = None, **fields: Any) -> int:
        """A node, under the scene or a parent; its number."""
        nodes = self._json["nodes"]
        nodes.append({"name": name, **fields})
        number = len(nodes) - 1
        if parent is None:
            self._json["scenes"][0]["nodes"].append(number)
        else:
            nodes[parent].setdefault("children", []).append(number)
        return number

    def mesh(
        self,
        name: str,
        shape: tuple[np.ndarray, np.ndarray],
        material_number: int,
        parent: int | None = None,
        **fields: Any,
    ) -> int:
        """A node with vertices [N,3] and triangles [M,3] of one material."""
        points = np.asarray(shape[0], dtype="<f4")
        small = len(points) < 2**16
        indices = np.asarray(shape[1]).reshape(-1).astype("<u2" if small else "<u4")
        position = self._add(
            points,
            ARRAY,
            componentType=FLOAT,
            type="VEC3",
            min=points.min(axis=0).tolist(),
            max=points.max(axis=0).tolist(),
        )
        index = self._add(
            indices, ELEMENTS, componentType=UINT16 if small else UINT32, type="SCALAR"
        )
        primitive = {
            "attributes": {"POSITION": position},
            "indices": index,
            "material": material_number,
        }
        self._json["meshes"].append({"name": name, "primitives": [primitive]})
        return self.node(name, parent, mesh=len(self._json["meshes"]) - 1, **fields)

    def camera(self, yfov: float, **fields: Any) -> None:
        """A perspective camera, `yfov` radians high, that looks along -z of its node."""
        perspective = {"yfov": yfov, "aspectRatio": 1.0, "znear": 0.01}
        self._json["cameras"] = [{"type": "perspective", "perspective": perspective}]
        self.node("camera", camera=0, **fields)

    def light(self, light: dict[str, Any], **fields: Any) -> None:
        """A light of KHR_lights_punctual, which shines along -z of its node."""
        self._extensions.add(LIGHTS)
        lights = self._json.setdefault("extensions", {}).setdefault(LIGHTS, {"lights": []})
        lights["lights"].append(light)
        number = len(lights["lights"]) - 1
        self.node(light["name"], extensions={LIGHTS: {"light": number}}, **fields)

    def turn(self, node: int, times: list[float], quaternions: list[list[float]]) -> None:
        """Turns a node by linear keys."""
        sampler = {
            "input": self._add(
                np.asarray(times, dtype="<f4"),
                None,
                componentType=FLOAT,
                type="SCALAR",
                min=[min(times)],
                max=[max(times)],
            ),
            "output": self._add(
                np.asarray(quaternions, dtype="<f4"), None, componentType=FLOAT, type="VEC4"
            ),
            "interpolation": "LINEAR",
        }
        channel = {"sampler": 0, "target": {"node": node, "path": "rotation"}}
        self._json["animations"] = [{"channels": [channel], "samplers": [sampler]}]

    def json(self) -> dict[str, Any]:
        uri = "data:application/octet-stream;base64," + base64.b64encode(self._data).decode()
        buffers = [{"byteLength": len(self._data), "uri": uri}]
        used = {"extensionsUsed": sorted(self._extensions)} if self._extensions else {}
        content = self._json | used | {"buffers": buffers}
        return {key: content[key] for key in ORDER if key in content}
