# SPDX-License-Identifier: MIT
"""The device that needs no hardware (voxshell/device.h, voxshell/simulated.h)."""
import ctypes

from .library import Memory, Struct, load, need
from .pose import Pose, Wrench, as_pose

CLOSED, NO_FIRMWARE, UNCALIBRATED, READY, ARMED, FAULT, GONE = range(7)


class DeviceState(Struct):
    """What was measured: sequence grows with each new measurement, time_ns is virtual or the host's; state: ARMED, ..."""

    C_NAME = "vxs_device_state"
    _fields_ = [("sequence", ctypes.c_uint64), ("time_ns", ctypes.c_int64), ("pose", Pose), ("velocity", ctypes.c_double * 3),
                ("angular_velocity", ctypes.c_double * 3), ("velocity_source", ctypes.c_uint32), ("buttons", ctypes.c_uint32),
                ("state", ctypes.c_uint32), ("fault", ctypes.c_uint32), ("link_age", ctypes.c_double)]


class DeviceCommand(Struct):
    """What the hand is to feel [N], [N m]: in full until hold_ns, nothing from expires_ns on."""

    C_NAME = "vxs_device_command"
    _fields_ = [("sequence", ctypes.c_uint64), ("wrench", Wrench), ("hold_ns", ctypes.c_int64), ("expires_ns", ctypes.c_int64)]


class SimulatedProfile(Struct):
    """A device's tip: peak_force [N], max_stiffness [N/m], resolution [m], mass [kg] (assumed), friction [N] ..."""

    C_NAME = "vxs_simulated_profile"
    _fields_ = [("name", ctypes.c_char_p),
                *[(name, ctypes.c_double) for name in ("peak_force", "continuous_force", "peak_torque", "max_stiffness", "max_damping",
                                                       "resolution", "mass", "friction", "viscosity", "rate_hz")]]


class SimulatedArm(Struct):
    """Who holds it: mass [kg], viscosity [N s/m] and stiffness [N/m] to where the hand wants to be. All assumed."""

    C_NAME = "vxs_simulated_arm"
    _fields_ = [("name", ctypes.c_char_p), ("mass", ctypes.c_double), ("viscosity", ctypes.c_double), ("stiffness", ctypes.c_double)]


class SimulatedConfig(Struct):
    C_NAME = "vxs_simulated_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("delay_samples", ctypes.c_uint32), ("substeps", ctypes.c_uint32),
                ("reserved", ctypes.c_uint32), ("profile", SimulatedProfile), ("arm", SimulatedArm), ("sample_time", ctypes.c_double),
                ("start", Pose), ("noise", ctypes.c_double), ("loss", ctypes.c_double), ("loss_time", ctypes.c_double),
                ("seed", ctypes.c_uint64)]

    @classmethod
    def default(cls, profile=None):
        made = cls()
        load().vxs_simulated_config_default(ctypes.byref(made), profile)
        if made.struct_size != ctypes.sizeof(cls):
            raise ImportError(f"{load()._name}: {cls.C_NAME} has another size there than here")
        return made


def simulated_names():
    """Of the devices that can be simulated: ["phantom-premium-1.5", "omega-3", ...]."""
    names, n = [], 0
    while load().vxs_simulated_profile_at(n):
        names.append(SimulatedProfile.from_address(load().vxs_simulated_profile_at(n)).name.decode())
        n += 1
    return names


class SimulatedDevice:
    """A felt mass with friction, held by an arm, on virtual time: the same motion to the last bit on every machine.

    name         of a profile (simulated_names())
    arm          free (nobody), pen, hand, arm
    rate         samples a second [Hz]; 0: the profile's
    start        pose of device and hand (3 or 7 numbers)
    noise        standard deviation of what each axis is measured with [m]
    loss         0 .. 0.9, share of samples that are lost; seed: of both
    delay        samples between a command and its effect, 1 .. 64

    Raises ValueError for a name that is none, Error for a number out of its range.
    """

    def __init__(self, name="phantom-premium-1.5", arm="hand", rate=0.0, start=(0.0, 0.0, 0.0), noise=0.0, loss=0.0, delay=1, seed=1):
        profile, holder = load().vxs_simulated_profile_named(name.encode()), load().vxs_simulated_arm_named(arm.encode())
        if not profile:
            raise ValueError(f"device '{name}': there are {', '.join(simulated_names())}")
        if not holder:
            raise ValueError(f"arm '{arm}': there are free, pen, hand, arm")
        self.config = SimulatedConfig.default(profile)
        self.config.arm = SimulatedArm.from_address(holder)
        if rate > 0:
            self.config.sample_time = 1 / rate
        self.config.start = as_pose(start)
        self.config.noise, self.config.loss, self.config.delay_samples, self.config.seed = noise, loss, delay, seed
        self._memory = Memory(load().vxs_simulated_memory())
        self._device = ctypes.c_void_p()
        need(load().vxs_simulated_open(self._memory.address, self._memory.size, ctypes.byref(self.config), ctypes.byref(self._device)), name)
        self.state = DeviceState()

    def arm(self):
        """From here on it pushes."""
        need(load().vxs_device_arm(self._device))

    def disarm(self):
        """Force off; ends a fault."""
        need(load().vxs_device_disarm(self._device))

    def hand(self, pose):
        """Where the hand wants to be at the end of the next sample: Pose, or 3 or 7 numbers."""
        pose = pose if isinstance(pose, Pose) else as_pose(pose)
        address = ctypes.addressof(pose)
        load().vxs_simulated_hand(self._device, address, address + Pose.orientation.offset)

    def exchange(self, command):
        """One sample: DeviceCommand in, DeviceState out (the same object each time)."""
        load().vxs_device_exchange(self._device, ctypes.byref(command), ctypes.byref(self.state), None)
        return self.state
