"""The same work in other people's simulators: a T650 on the circle of 5 m at 7 m/s, with their own controller."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from uavlab.plant import load_airframe
from uavlab.types import GRAVITY

RADIUS, SPEED = 5.0, 7.0


def rotorpy_lean(
    physics: float, control: float = 100.0, speed: float = SPEED
) -> Callable[[float], float]:
    """RotorPy's vehicle, SE(3) controller and trajectory in the shortest loop: no log, no sensors."""
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.vehicles.multirotor import Multirotor

    parameters, trajectory = _rotorpy_t650(), _rotorpy_circle(speed)
    every = round(physics / control)

    def run(seconds: float) -> float:
        state = _rotorpy_start(speed)
        vehicle = Multirotor(parameters, initial_state=state)
        controller = SE3Control(parameters)
        for k in range(round(seconds * physics)):
            t = k / physics
            if k % every == 0:
                flat = trajectory.update(t)
                command = controller.update(t, state, flat)
            state = vehicle.step(state, command, 1.0 / physics)
        return float(np.linalg.norm(state["x"] - flat["x"]))

    return run


def rotorpy_run() -> Callable[[float], float]:
    """RotorPy as its first example runs it: Environment.run with log, sensors and estimator, 100 Hz."""
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.environments import Environment
    from rotorpy.vehicles.multirotor import Multirotor
    from rotorpy.world import World

    parameters, trajectory = _rotorpy_t650(), _rotorpy_circle()
    room = World.empty((-20, 20, -20, 20, -20, 20))

    def run(seconds: float) -> float:
        start = _rotorpy_start()
        vehicle = Multirotor(parameters, initial_state=start)
        sim = Environment(vehicle, SE3Control(parameters), trajectory, world=room, sim_rate=100)
        sim.vehicle.initial_state = start
        out = sim.run(t_final=seconds, use_mocap=False, terminate=False, verbose=False)
        return float(np.linalg.norm(out["state"]["x"][-1] - out["flat"]["x"][-1]))

    return run


def _rotorpy_t650() -> dict:
    a = load_airframe("T650")
    kf = a.thrust_coefficient
    places = a.arm * np.column_stack((np.cos(a.angles), np.sin(a.angles), np.zeros(a.n)))
    zero = dict.fromkeys(
        ("Ixy", "Iyz", "Ixz", "k_d", "k_z", "k_h", "k_flap", "motor_noise_std"), 0.0
    )
    return zero | {
        "mass": a.m, "Ixx": a.J[0, 0], "Iyy": a.J[1, 1], "Izz": a.J[2, 2],
        "num_rotors": a.n, "rotor_radius": a.propeller_radius,
        "rotor_pos": {f"r{i + 1}": place for i, place in enumerate(places)},
        "rotor_directions": a.spins, "rI": np.zeros(3),
        "c_Dx": a.drag_body, "c_Dy": a.drag_body, "c_Dz": a.drag_body,
        "k_eta": kf, "k_m": kf * a.torque_ratio, "tau_m": a.motor_tau,
        "rotor_speed_min": a.speed_min, "rotor_speed_max": a.speed_max,
        "k_w": 1, "k_v": 10, "kp_att": 150.0, "kd_att": 20.0,
    }  # fmt: skip


def _rotorpy_circle(speed: float = SPEED) -> object:
    from rotorpy.trajectories.circular_traj import ThreeDCircularTraj

    turns = speed / RADIUS / (2 * np.pi)
    return ThreeDCircularTraj(
        center=np.array([0, 0, 3.0]), radius=np.array([RADIUS, RADIUS, 0]), freq=np.full(3, turns)
    )


def _rotorpy_start(speed: float = SPEED) -> dict:
    a = load_airframe("T650")
    hover = np.sqrt(a.m * GRAVITY / a.n / a.thrust_coefficient)
    return {
        "x": np.array([RADIUS, 0, 3.0]), "v": np.array([0, speed, 0]), "q": np.array([0, 0, 0, 1.0]),
        "w": np.zeros(3), "wind": np.zeros(3), "rotor_speeds": np.full(a.n, hover),
    }  # fmt: skip


MODEL = """
<mujoco>
  <option timestep="0.001" integrator="RK4" gravity="0 0 -{g}"/>
  <worldbody>
    <body name="aircraft" pos="{radius} 0 3">
      <freejoint/>
      <inertial pos="0 0 0" mass="{m}" diaginertia="{jx} {jy} {jz}"/>
      <site name="centre"/>
      {sites}
    </body>
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>
"""


def mujoco(rate_loop: float) -> Callable[[float], float]:
    """MuJoCo's free body with four thrusters, RK4 at 1 kHz, our SE(3)-type stand-in in Python at 100 Hz.

    Parameters
    ----------
    rate_loop : float
        [Hz] at which the body-rate loop runs in Python: 1000 is the same work as ours (where it is
        compiled), 100 the cheapest.
    """
    import mujoco as mj

    from uavlab.parts.controllers import TiltAxis
    from uavlab.types import Estimate

    a = load_airframe("T650")
    model = mj.MjModel.from_xml_string(_mujoco_model(a))
    inverse = np.linalg.pinv(a.allocation)
    part, reference_at = TiltAxis(a.m), circle_reference()
    gain = 20.0 * a.J

    def run(seconds: float) -> float:
        data = mj.MjData(model)
        data.qvel[:3] = 0, SPEED, 0
        R, memory = np.zeros(9), part.init(None, None)
        every = round(1000 / rate_loop)
        for k in range(round(seconds * 1000)):
            if k % 10 == 0:
                mj.mju_quat2Mat(R, data.qpos[3:7])
                here = Estimate(data.qpos[:3], data.qvel[:3], None, R.reshape(3, 3), data.qvel[3:6])
                reference = reference_at(k / 1000)
                memory, command = part.step(memory, here, reference, 0.01)
            if k % every == 0:
                w = data.qvel[3:6]
                torque = gain @ (command.omega_d - w) + np.cross(w, a.J @ w)
                wish = inverse @ np.array((command.f_d, *torque))
                data.ctrl[:] = np.clip(wish, a.thrust_min, a.thrust_max)
            mj.mj_step(model, data)
        return float(np.linalg.norm(data.qpos[:3] - reference.r))

    return run


def _mujoco_model(a: object) -> str:
    sites, actuators = [], []
    for i, (angle, spin) in enumerate(zip(a.angles, a.spins, strict=True)):
        x, y = a.arm * np.cos(angle), a.arm * np.sin(angle)
        sites.append(f'<site name="rotor{i}" pos="{x} {y} 0"/>')
        gear = f"0 0 1 0 0 {spin * a.torque_ratio}"
        actuators.append(
            f'<general name="motor{i}" site="rotor{i}" gear="{gear}" dyntype="filter" '
            f'dynprm="{a.motor_tau}"/>'
        )
    jx, jy, jz = np.diag(a.J)
    return MODEL.format(
        g=GRAVITY, radius=RADIUS, m=a.m, jx=jx, jy=jy, jz=jz,
        sites="".join(sites), actuators="".join(actuators),
    )  # fmt: skip


def circle_reference(speed: float = SPEED) -> Callable[[float], object]:
    """The reference on the circle, uniform from the start."""
    from uavlab.parts.missions import Follow
    from uavlab.parts.paths import circle

    follow = Follow(circle(np.array([0.0, 0.0, 3.0]), RADIUS), speed / RADIUS, ramp=1e-9)
    return follow.goal
