# SPDX-License-Identifier: MIT
"""Devices, and the one that needs no hardware (voxshell/device.h, voxshell/simulated.h)."""
import ctypes
import weakref

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


class DeviceCaps(Struct):
    """What a device can do; 0 where it is not known: peak_force [N], max_stiffness [N/m], resolution [m], has_motors ..."""

    C_NAME = "vxs_device_caps"
    _fields_ = [("name", ctypes.c_char * 48), ("dof_sensed", ctypes.c_uint32), ("dof_actuated", ctypes.c_uint32),
                *[(name, ctypes.c_double) for name in ("rate_hz", "peak_force", "continuous_force", "peak_torque", "max_stiffness", "max_damping",
                                                       "resolution", "mass", "friction", "viscosity")],
                *[(name, ctypes.c_uint32) for name in ("delay_samples", "assumed", "has_watchdog", "verified", "has_motors")]]


class DeviceView(Struct):
    C_NAME = "vxs_device"
    _fields_ = [("ops", ctypes.c_void_p), ("self", ctypes.c_void_p), ("caps", DeviceCaps)]


class Device:
    """Any device, by the address of its vxs_device; keep: what has to live as long. caps (DeviceCaps), state (of the last exchange)."""

    def __init__(self, address, keep=None):
        self.address = address
        self.state = DeviceState()
        self.is_taken = False  # by a ServoThread
        self._close = weakref.finalize(self, _close, address, keep)

    def need_free(self):
        """Raises RuntimeError where a loop has it, or where it is closed."""
        if self.is_taken:
            raise RuntimeError("the device is its servo thread's until that is stopped")
        if not self._close.alive:
            raise RuntimeError("the device is closed")

    @property
    def caps(self):
        """A copy."""
        return DeviceCaps.from_buffer_copy(DeviceView.from_address(self.address).caps)

    def arm(self):
        """From here on it pushes. Raises Error: VXS_STATE."""
        self.need_free()
        need(load().vxs_device_arm(self.address))

    def disarm(self):
        """Force off; ends a fault. Raises Error."""
        self.need_free()
        need(load().vxs_device_disarm(self.address))

    def release(self):
        """Force off, whatever state it is in."""
        self.need_free()
        load().vxs_device_disarm(self.address)

    def exchange(self, command):
        """One sample: DeviceCommand in, DeviceState out (the same object each time)."""
        self.need_free()
        load().vxs_device_exchange(self.address, ctypes.byref(command), ctypes.byref(self.state), None)
        return self.state

    def close(self):
        """Force off and the end; again is allowed."""
        if self.is_taken:
            raise RuntimeError("the device is its servo thread's until that is stopped")
        self._close()


def _close(address, _keep):
    load().vxs_device_close(address)


class SimulatedDevice(Device):
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
        memory, opened = Memory(load().vxs_simulated_memory()), ctypes.c_void_p()
        need(load().vxs_simulated_open(memory.address, memory.size, ctypes.byref(self.config), ctypes.byref(opened)), name)
        super().__init__(opened.value, memory)

    def hand(self, pose):
        """Where the hand wants to be at the end of the next sample: Pose, or 3 or 7 numbers."""
        self.need_free()
        pose = pose if isinstance(pose, Pose) else as_pose(pose)
        address = ctypes.addressof(pose)
        load().vxs_simulated_hand(self.address, address, address + Pose.orientation.offset)
