"""What stands in a replay: the aircraft, frames, paths, the ground, the camera."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.flight.log import Log
from uavlab.types import GRAVITY, Array, Vec3
from uavlab.views import style
from uavlab.views.cast import rotor_places
from uavlab.views.scene import Scene, ball, box, cone, lines, look, painted, triad, tubes

CCW, CW = "#3B7DD8", "#E0902F"  # rotors by the sense in which they spin, seen from above
NOSE = "#D0342C"


class Keys(NamedTuple):
    """The ticks of a log at which a replay has key frames."""

    rows: Array  # (K,) indices into the log
    t: Array  # (K,) [s], from 0


def keys(log: Log, rate: float) -> Keys:
    """Key frames at about `rate` [Hz]; the first and the last tick are among them."""
    if not len(log.t):
        return Keys(np.zeros(0, dtype=int), np.zeros(0))
    span = float(log.t[-1] - log.t[0])
    wanted = np.linspace(0.0, span, max(2, int(np.ceil(span * rate)) + 1))
    rows = np.unique(np.searchsorted(log.t - log.t[0], wanted - 1e-9).clip(0, len(log.t) - 1))
    return Keys(rows, log.t[rows] - log.t[0])


def add_aircraft(scene: Scene, at: str, log: Log, scale: float, ghost: str | None = None) -> None:
    """Hub, arms, rotors coloured by spin, and a red nose. A ghost is all of one colour, and pale."""
    places, spins, radius = rotor_places(log)
    places, radius = scale * places, scale * radius
    arm = float(np.linalg.norm(places[0]))

    def paint(color: str, opacity: float = 1.0) -> object:
        return look(color, opacity) if ghost is None else look(ghost, 0.4 * opacity)

    scene.add(f"{at}/hub", box((0.5 * arm, 0.34 * arm, 0.16 * arm)), paint("#39424E"))
    _stick(
        scene, f"{at}/nose", (0.25 * arm, 0, 0), (0.75 * arm, 0, 0), 0.11 * arm, 0.0, paint(NOSE)
    )
    for k, (place, spin) in enumerate(zip(places, spins, strict=True)):
        up = np.array([0, 0, 0.06 * arm])
        disc = np.array([0, 0, 0.02 * arm])
        color = CW if spin > 0 else CCW
        _stick(scene, f"{at}/arm{k}", np.zeros(3), place, 0.035 * arm, 0.03 * arm, paint("#39424E"))
        _stick(scene, f"{at}/motor{k}", place, place + up, 0.07 * arm, 0.07 * arm, paint("#222222"))
        _stick(
            scene,
            f"{at}/rotor{k}",
            place + up,
            place + up + disc,
            radius,
            radius,
            paint(color, 0.55),
        )


def add_thrusts(scene: Scene, at: str, log: Log, key: Keys, scale: float) -> None:
    """A cone on each rotor, as long as its thrust: one arm's length for what it carries in hover."""
    places, _, _ = rotor_places(log)
    n = log.rotors.shape[1]
    if n != len(places) or not style.seen(log.rotors):
        return
    arm = scale * float(np.linalg.norm(places[0]))
    hover = float(log.meta.get("mass") or 0.0) * GRAVITY / n or float(np.nanmean(log.rotors))
    thrust = np.nan_to_num(log.rotors[key.rows]) / max(hover, 1e-9)
    for k, place in enumerate(places):
        node = f"{at}/thrust{k}"
        shape, r, R = cone(np.zeros(3), np.array([0, 0, arm]), 0.055 * arm)
        scene.add(f"{node}/cone", shape, look("#2CA02C", 0.85))
        scene.place(f"{node}/cone", r, R)
        scene.place(node, scale * place + [0, 0, 0.08 * arm])
        length = thrust[:, k].clip(0.01)
        scene.move(node, key.t, scale=np.stack([0 * length + 1, 0 * length + 1, length], axis=1))


def add_frame(scene: Scene, at: str, size: float) -> None:
    """A frame of three sticks: x red, y green, z blue."""
    thick = 0.035 * size
    for i, color in enumerate(style.XYZ):
        tip = size * np.eye(3)[i]
        _stick(scene, f"{at}/{'xyz'[i]}", np.zeros(3), tip, thick, thick, look(color))
    scene.add(f"{at}/origin", ball(2 * thick), look("#444444"))


def add_trail(scene: Scene, at: str, points: Array, radius: float, color: str | list[str]) -> bool:
    """The path as a tube, of one colour or of one for each point; False if it is too short to draw."""
    if len(points) < 2:
        return False
    if isinstance(color, str):
        scene.add(at, tubes([points], radius), look(color))
    else:
        scene.add(at, tubes([points], radius, colors=color), painted())
    return True


def add_dashes(scene: Scene, at: str, points: Array, radius: float, color: str) -> None:
    """A dashed path: what was asked."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if len(points) < 2 or length[-1] < 1e-6:
        return
    count = int(min(80, max(12, length[-1] / (12 * radius))))
    pieces = []
    for k in range(count):
        inside = np.linspace(k, k + 0.55, 3) * length[-1] / count
        pieces.append(np.stack([np.interp(inside, length, points[:, i]) for i in range(3)], axis=1))
    scene.add(at, tubes(pieces, radius, sides=3), look(color))


def add_ground(scene: Scene, low: Vec3, high: Vec3) -> float:
    """A floor with a grid under everything, and the world's axes; the grid's step [m] is returned."""
    side = float(max(high[0] - low[0], high[1] - low[1]))
    step = next(s for s in (0.5, 1, 2, 5, 10, 20, 50, 100, 1e9) if side / s <= 16 or s >= 1e9)
    edge = step * np.array([np.floor(low[:2] / step) - 1, np.ceil(high[:2] / step) + 1])
    z = float(min(low[2], 0.0))
    size = edge[1] - edge[0]
    rows: list[list[float]] = []
    for i in (0, 1):
        for c in np.arange(edge[0, i], edge[1, i] + step / 2, step):
            ends = np.array([[*edge[0], z], [*edge[1], z]])
            ends[:, i] = c
            rows += ends.tolist()
    scene.add("uavlab/ground/floor", box((float(size[0]), float(size[1]), 0.01)), look("#F2F0EA"))
    scene.place("uavlab/ground/floor", [*(edge.mean(axis=0)), z - 0.012])
    scene.add("uavlab/ground/grid", lines(np.array(rows), "#B9B6AC"), None)
    scene.add("uavlab/ground/world", triad(step), None)
    scene.place("uavlab/ground/world", [0, 0, z + 0.005])
    return step


def add_shadow(scene: Scene, at: str, log: Log, key: Keys, floor: float, size: float) -> None:
    """A disc on the ground below the aircraft and a thin line up to it: how eyes judge height."""
    r = log.r[key.rows]
    ground = np.column_stack([r[:, :2], np.full(len(r), floor + 0.004)])
    _stick(
        scene, f"{at}/disc", np.zeros(3), np.array([0, 0, 0.004]), size, size, look("#77736A", 0.5)
    )
    up, thin = np.array([0, 0, 1.0]), 0.02 * size
    _stick(scene, f"{at}/plumb/line", np.zeros(3), up, thin, thin, look("#8A867C"))
    scene.move(at, key.t, r=ground)
    height = (r[:, 2] - floor).clip(0.01)
    scene.move(
        f"{at}/plumb", key.t, scale=np.stack([0 * height + 1, 0 * height + 1, height], axis=1)
    )


def add_light_and_camera(scene: Scene, low: Vec3, high: Vec3) -> list[float]:
    """A bright room, and a camera that sees all of it; what it should look at is returned, in y-up axes."""
    scene.set("Background", "top_color", [0.72, 0.83, 0.94])
    scene.set("Background", "bottom_color", [0.97, 0.97, 0.95])
    for node in ("Grid", "Axes", "Lights/PointLightNegativeX", "Lights/PointLightPositiveX"):
        scene.set(node, "visible", False)
    scene.set("Lights/AmbientLight/<object>", "intensity", 0.62)
    scene.set("Lights/FillLight/<object>", "position", [-4.0, -6.0, 9.0])
    scene.set("Lights/FillLight/<object>", "intensity", 0.5)
    centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    eye = centre + 1.8 * radius * np.array([0.45, -0.78, 0.46])
    scene.place(
        "Cameras/default", (*centre[:2], centre[2] + 0.22 * radius)
    )  # room above for the caption
    camera = "Cameras/default/rotated/<object>"
    scene.set(camera, "fov", 45.0)
    scene.set(camera, "near", radius / 200)
    scene.set(camera, "far", 60 * radius)
    scene.set(camera, "position", y_up(eye))
    return y_up(centre)


def y_up(r: Vec3) -> list[float]:
    """A point of our z-up world (3,) [m] in the viewer's own y-up world, in which its camera lives."""
    return [float(r[0]), float(r[2]), -float(r[1])]


def _stick(
    scene: Scene, at: str, base: object, tip: object, bottom: float, top: float, paint: object
) -> None:
    shape, r, R = cone(np.asarray(base, dtype=float), np.asarray(tip, dtype=float), bottom, top)
    scene.add(at, shape, paint)
    scene.place(at, r, R)
