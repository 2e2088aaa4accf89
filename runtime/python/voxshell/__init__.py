# SPDX-License-Identifier: MIT
"""voxshell for people who plan experiments: assets as numpy arrays, and the runtime that feels them.

    import voxshell as vxs

    cup, ball = vxs.Voxmap("assets/cup_hold.voxmap"), vxs.Pointshell("assets/cup_hold.pointshell")
    ball.positions                              # (N, 3) float32 [m], a view of the mapped file
    cup.states()                                # a dense array of cells
    touch = vxs.Contact(ball, cup, law="patch", field="distance", weighting="area", stiffness=3e8)
    result = touch.evaluate([0.047, 0.04, 0])   # at a position [m], or at arrays of poses
    result["wrench"]["force"]                   # [N]

    plan = vxs.Plan("assets/cup_hold.plan")     # a compiled scene
    config = plan.config()
    config.contact.stiffness = 1e8              # what the experiment varies
    rows = plan.simulate(config, arm="pen")     # one row a tick, the same bits on every run
    rows["command"]["force"][:, 0].min()

All numbers are SI; quaternions are w x y z. What the runtime refuses is raised as Error, in its own words.
"""
from .asset import Asset
from .contact import Contact, ContactFlag, ContactResult, Statics
from .device import ARMED, FAULT, GONE, READY, Device, DeviceCaps, DeviceCommand, DeviceState, SimulatedDevice, simulated_names
from .hardware import REPLAY_ROW, HardwareDevice, ReplayDevice, hardware_names
from .library import Error, load
from .plan import Plan
from .pointshell import Pointshell
from .pose import Pose, Wrench
from .servo import ROW, COUPLINGS, Servo, ServoConfig, ServoFlag
from .servo_thread import Histogram, ServoFault, ServoThread, ServoThreadStatus
from .voxmap import FREE, INTERIOR, SURFACE, Voxmap

_version = load().vxs_version()
__version__ = f"{_version >> 16}.{_version >> 8 & 255}.{_version & 255}"

__all__ = ["open_asset", "Asset", "Voxmap", "Pointshell", "Plan", "Contact", "ContactFlag", "ContactResult", "Statics", "Servo", "ServoConfig", "ServoFlag",
           "ServoThread", "ServoThreadStatus", "ServoFault", "Histogram", "Device", "DeviceCaps", "HardwareDevice", "hardware_names", "ReplayDevice",
           "REPLAY_ROW", "SimulatedDevice", "simulated_names", "DeviceState", "DeviceCommand", "Pose", "Wrench", "Error", "ROW", "COUPLINGS", "FREE",
           "SURFACE", "INTERIOR", "READY", "ARMED", "FAULT", "GONE"]


def open_asset(path, copy=False):
    """A Voxmap, a Pointshell or a Plan, by what the file is, whatever its name. Raises as Asset."""
    with open(path, "rb") as file:
        magic = file.read(4)
    return {b"\x89VXM": Voxmap, b"\x89VXP": Pointshell, b"\x89VXL": Plan}.get(magic, Asset)(path, copy)
