"""A scene for meshcat's viewer: its messages, collected instead of sent to a server."""

from __future__ import annotations

import struct
import warnings
import zlib
from itertools import count
from typing import Any

import numpy as np

from uavlab.types import Array, Mat3, Vec3

with warnings.catch_warnings():  # meshcat imports a deprecated corner of pyzmq
    warnings.simplefilter("ignore")
    from meshcat import animation, commands, geometry
    from meshcat.path import Path
    from umsgpack import packb


class Scene:
    """Things by path ("uavlab/aircraft/arm0"), where they are, and how they move."""

    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []
        self._clips: dict[Path, animation.AnimationClip] = {}
        self._numbers = count()

    def add(self, path: str, shape: Any, look: Any) -> None:
        """Put an object (geometry and material, or a ready `meshcat.geometry.Object`) at `path`."""
        thing = shape if isinstance(shape, geometry.Object) else geometry.Mesh(shape, look)
        for element in (
            thing,
            thing.geometry,
            thing.material,
        ):  # the same scene twice: the same bytes
            element.uuid = f"uavlab-{next(self._numbers)}"
        self.messages.append(commands.SetObject(thing, path=_path(path)).lower())

    def place(
        self, path: str, r: Any = (0, 0, 0), R: Mat3 | None = None, scale: float = 1.0
    ) -> None:
        """Where a node is in its parent: position [m], rotation node → parent, size [1]."""
        pose = np.eye(4)
        pose[:3, :3] = scale * (np.eye(3) if R is None else R)
        pose[:3, 3] = r
        self.messages.append(commands.SetTransform(pose, _path(path)).lower())

    def set(self, path: str, key: str, value: Any) -> None:
        """Set a property of the viewer's node."""
        self.messages.append(commands.SetProperty(key, value, _path(path)).lower())

    def move(
        self, path: str, t: Array, r: Array | None = None, R: Array | None = None,
        scale: Array | None = None,
    ) -> None:  # fmt: skip
        """Move a node in time.

        Parameters
        ----------
        path : str
            The node.
        t : Array
            Key times [s], (N,).
        r, R, scale : Array, optional
            Position [m] (N, 3), rotation node → parent (N, 3, 3), size along the axes [1] (N, 3).
        """
        clip = self._clips.setdefault(_path(path), animation.AnimationClip(fps=1))
        tracks = (("position", "vector3", r), ("scale", "vector3", scale))
        for name, kind, values in tracks:
            if values is not None:
                clip.tracks[name] = animation.AnimationTrack(
                    name, kind, t.tolist(), values.tolist()
                )
        if R is not None:
            from scipy.spatial.transform import Rotation

            q = Rotation.from_matrix(R).as_quat()  # x, y, z, w: the order of three.js, too
            track = animation.AnimationTrack("quaternion", "quaternion", t.tolist(), q.tolist())
            clip.tracks["quaternion"] = track

    def packed(self, page: bytes) -> bytes:
        """`page` and all messages as one deflated block: each with its length (4 bytes, big-endian) in front."""
        moves = commands.SetAnimation(animation.Animation(self._clips), play=False).lower()
        blocks = [page]
        blocks += [packb(m, force_float_precision="single") for m in [*self.messages, moves]]
        return zlib.compress(b"".join(struct.pack(">I", len(b)) + b for b in blocks), 9)


def _path(path: str) -> Path:
    return Path(tuple(part for part in path.split("/") if part))


# Shapes --------------------------------------------------------------------------------------------


def look(color: str, opacity: float = 1.0) -> Any:
    """A matt material in the colour ``#rrggbb``."""
    return geometry.MeshLambertMaterial(color=int(color[1:], 16), opacity=opacity, reflectivity=0.2)


def painted() -> Any:
    """A matt material for what has a colour at each corner."""
    return geometry.MeshLambertMaterial(color=0xFFFFFF, vertexColors=True, reflectivity=0.2)


def box(lengths: tuple[float, float, float]) -> Any:
    """A box with these side lengths [m] along x, y, z."""
    return geometry.Box(list(lengths))


def ball(radius: float) -> Any:
    """A sphere [m]."""
    return geometry.Sphere(radius)


def mesh(vertices: Array, faces: Array) -> Any:
    """Triangles: corners (N, 3) [m], and indices of them (M, 3)."""
    return geometry.TriangularMeshGeometry(vertices, faces)


def tubes(
    paths: list[Array], radius: float, sides: int = 4, colors: list[str] | None = None
) -> Any:
    """Tubes [m] around polylines (N, 3), as one mesh; every piece takes ``6 * sides`` indices, in order.

    With `colors` ``#rrggbb``, one for each point of all polylines, it must be looked at by `painted`.
    """
    vertices: list[Array] = []
    faces: list[Array] = []
    for points in paths:
        first = sum(map(len, vertices))
        vertices.append((points[:, None] + radius * _rings(points, sides)).reshape(-1, 3))
        k, s = np.meshgrid(np.arange(len(points) - 1), np.arange(sides), indexing="ij")
        a, b = first + k * sides + s, first + k * sides + (s + 1) % sides
        pair = np.stack([a, b, a + sides, b, b + sides, a + sides], axis=-1)
        faces.append(pair.reshape(-1, 3))
    paint = None if colors is None else np.repeat([_rgb(x) for x in colors], sides, axis=0)
    return geometry.TriangularMeshGeometry(np.concatenate(vertices), np.concatenate(faces), paint)


def _rgb(color: str) -> list[float]:
    return [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]


def _rings(points: Array, sides: int) -> Array:
    """Unit vectors across a polyline, (N, sides, 3)."""
    ahead = np.gradient(points, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True).clip(1e-9)
    level = np.cross(ahead, [0.0, 0.0, 1.0])
    flat = np.linalg.norm(level, axis=1, keepdims=True)
    level = np.where(flat > 1e-3, level / flat.clip(1e-9), [1.0, 0.0, 0.0])
    across = np.cross(level, ahead)
    turn = 2 * np.pi * np.arange(sides) / sides
    return np.cos(turn)[:, None] * level[:, None] + np.sin(turn)[:, None] * across[:, None]


def cone(base: Vec3, tip: Vec3, bottom: float, top: float = 0.0) -> tuple[Any, Vec3, Mat3]:
    """A cone or cylinder from `base` to `tip` [m]: its geometry, and where to place it (r, R)."""
    axis = np.asarray(tip, dtype=float) - base
    length = float(np.linalg.norm(axis))
    y = axis / length  # three.js' cylinders stand along y
    side = np.array([0.0, 0.0, 1.0]) if abs(y[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(y, side)
    x /= np.linalg.norm(x)
    R = np.stack([x, y, np.cross(x, y)], axis=1)
    shape = geometry.Cylinder(length, radiusTop=float(top), radiusBottom=float(bottom))
    shape.radialSegments = 20
    return shape, np.asarray(base) + axis / 2, R


def lines(points: Array, color: str) -> Any:
    """Separate line pieces: points (2 N, 3) [m] in pairs."""
    shape = geometry.PointsGeometry(np.asarray(points, dtype=np.float32).T)
    paint: Any = geometry.LineBasicMaterial(color=int(color[1:], 16))
    return geometry.LineSegments(shape, paint)


def triad(size: float) -> Any:
    """Three lines along x (red), y (green), z (blue) of length `size` [m]."""
    return geometry.triad(size)
