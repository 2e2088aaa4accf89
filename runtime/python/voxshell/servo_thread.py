# SPDX-License-Identifier: MIT
"""The servo on the wall clock (voxshell/servo_thread.h): a thread of C's that runs exchange and tick. Python starts it, looks at it and
ends it, and is never in it: no interpreter lock, no garbage collection can delay a tick.

    device = vxs.HardwareDevice("hvlink", "/dev/ttyACM0")        # or SimulatedDevice, ReplayDevice
    with vxs.ServoThread(vxs.Servo(plan.config()), device) as loop:
        loop.arm()
        while loop.running:
            time.sleep(0.5)
            rows = loop.rows()                                   # what came since the last time; loop.lost
            loop.check()                                         # raises ServoFault
"""
import ctypes
import os
import time
import warnings
import weakref

import numpy as np

from .library import Memory, Struct, load, need
from .servo import ROW, ServoFlag

BINS = 32


class Histogram(Struct):
    """Of durations: bins[0] counts those below 1 us, bins[n] those from 2^(n-1) to 2^n us, the last one all above; max_ns."""

    C_NAME = "vxs_servo_thread_histogram"
    _fields_ = [("bins", ctypes.c_uint64 * BINS), ("max_ns", ctypes.c_uint64)]

    @property
    def counts(self):
        """Of each bin: an array of uint64, a copy."""
        return np.array(self.bins, dtype=np.uint64)

    def at_most(self, share):
        """What a share 0 .. 1 of them stayed below [s]: the upper end of a bin, or the largest if that is less; nan without any."""
        counts = self.counts
        if not counts.sum():
            return float("nan")
        n = int(np.searchsorted(np.cumsum(counts), np.ceil(share * int(counts.sum()))))
        return min(2.0**n * 1e-6 if n < BINS - 1 else np.inf, self.max_ns * 1e-9)

    def add(self, other):
        for n in range(BINS):
            self.bins[n] += other.bins[n]
        self.max_ns = max(self.max_ns, other.max_ns)


class ServoThreadStatus(Struct):
    """A snapshot: running, is_realtime, is_locked, is_pinned, scheduling_text and memory_text (what was granted, or why not and what
    helps), ticks, missed (periods skipped), last_flags and seen_flags (ServoFlag | ContactFlag), lateness and work (Histogram)."""

    C_NAME = "vxs_servo_thread_status"
    _fields_ = [*[(name, ctypes.c_uint32) for name in ("running", "is_realtime", "is_locked", "is_pinned")],
                ("scheduling_text", ctypes.c_char_p), ("memory_text", ctypes.c_char_p), ("ticks", ctypes.c_uint64), ("missed", ctypes.c_uint64),
                ("last_flags", ctypes.c_uint32), ("seen_flags", ctypes.c_uint32), ("lateness", Histogram), ("work", Histogram)]


class ServoThreadConfig(Struct):
    C_NAME = "vxs_servo_thread_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("lock_memory", ctypes.c_uint32), ("priority", ctypes.c_int32), ("cpu", ctypes.c_int32),
                ("rate_hz", ctypes.c_double), ("max_ticks", ctypes.c_uint64),
                *[(name, ctypes.c_void_p) for name in ("device", "servo", "trace", "live", "on_tick", "user")]]


class ServoFault(Exception):
    """The loop gives no force any more: its servo is in FAULT (flags has ServoFlag.FAULT) or its device is lost (DEVICE_LOST)."""

    def __init__(self, flags):
        self.flags = flags
        what = "the servo is in FAULT: a number that was not finite, or an asset that lost bytes; clear() ends it" if flags & ServoFlag.FAULT \
            else "the device is lost: in a fault (disarm() ends it), gone, or silent"
        super().__init__(what)


class ServoThread:
    """servo (Servo) on device (a Device), from start() to stop(); meanwhile both are the thread's alone: what touches them raises
    RuntimeError. As a context manager it starts, and at the end stops and disarms.

    rate         ticks a second [Hz], 100 .. 10000: the servo's config.coupling.sample_time is to be 1 / rate
    ring         rows that wait for rows(), at least; what comes while it is full is lost, and counted
    priority     of SCHED_FIFO, 1 .. 99; 0: leave the scheduler alone. lock_memory: mlockall. cpu: pin to this one; -1: no.
                 What is not allowed is done without: status() says so
    max_ticks    stop after so many; 0: run on

    Raises ValueError for a rate that is not the servo's, Error as vxs_servo_thread_start(): VXS_UNGUARDED for a device with motors and
    a servo without start-inside and soft-start.
    """

    def __init__(self, servo, device, rate=None, ring=8192, priority=80, lock_memory=True, cpu=-1, max_ticks=0):
        sample_time = servo.config.coupling.sample_time
        rate = 1 / sample_time if rate is None else rate
        if abs(rate * sample_time - 1) > 1e-9:
            raise ValueError(f"rate {rate:g} Hz: the servo was made for {1 / sample_time:g} Hz (config.coupling.sample_time)")
        self.servo, self.device = servo, device
        self._rows = 1 << max(int(ring) - 1, 0).bit_length()
        self._ring = Memory(load().vxs_trace_memory(self._rows))
        self._trace = ctypes.c_void_p()
        need(load().vxs_trace_init(self._ring.address, self._ring.size, self._rows, ctypes.byref(self._trace)), f"ring of {ring} rows")
        self.config = ServoThreadConfig.default()
        self.config.rate_hz, self.config.priority, self.config.cpu = rate, priority, cpu
        self.config.lock_memory, self.config.max_ticks = bool(lock_memory), max_ticks
        self.config.trace = self._trace
        self._memory = Memory(load().vxs_servo_thread_memory())
        self._thread = None
        self._stop = None
        self._past = ServoThreadStatus()  # of the loops before the one that runs
        self._told = 0

    def start(self):
        """From here on it ticks, on a device that is armed or not."""
        if self._stop:
            raise RuntimeError("the loop runs already")
        if self.config.max_ticks and self.config.max_ticks <= self._past.ticks:
            raise RuntimeError(f"the loop has done its {self.config.max_ticks} ticks")
        for part in (self.servo, self.device):
            part.need_free()
        config = ServoThreadConfig.from_buffer_copy(self.config)
        config.device, config.servo = self.device.address, self.servo.address
        if config.max_ticks:
            config.max_ticks -= self._past.ticks
        thread = ctypes.c_void_p()
        need(load().vxs_servo_thread_start(self._memory.address, self._memory.size, ctypes.byref(config), ctypes.byref(thread)), "servo thread")
        self._thread = thread
        self.servo.is_taken = self.device.is_taken = True
        # Whoever drops the loop, or leaves the interpreter, stops it first: its memory, servo and device are Python's.
        self._stop = weakref.finalize(self, _end, os.getpid(), thread, self.servo, self.device, (self._memory, self._ring))

    def stop(self):
        """Ends after the tick that runs, with a last exchange that commands zero, and waits for it. The device stays armed. Nothing happens if
        it does not run."""
        if not self._stop:
            return
        self._stop()
        self._stop = None
        self._past = self._sum()
        self._thread = None

    def _between(self, act):
        """What only someone who owns device and servo may do: between two loops, a tick or two apart."""
        runs = self.running
        self.stop()
        try:
            act()
        finally:
            if runs and not self._is_over():
                self.start()

    def _is_over(self):
        return self.config.max_ticks and self._past.ticks >= self.config.max_ticks

    def arm(self):
        """The device pushes from here on, after the servo's soft-start. A loop that runs pauses for it. Raises Error: VXS_STATE for a
        device in FAULT or GONE; a running loop goes on all the same."""
        self._between(self.device.arm)

    def disarm(self):
        """Force off; ends a device's fault. A loop that runs pauses for it."""
        self._between(self.device.disarm)

    def clear(self):
        """Ends the servo's FAULT. A loop that runs pauses for it."""
        self._between(self.servo.clear)

    @property
    def running(self):
        """Whether it ticks: False before start(), after stop() and after max_ticks."""
        return self._stop is not None and bool(self._now().running)

    def _now(self):
        status = ServoThreadStatus()
        load().vxs_servo_thread_get(self._thread, ctypes.byref(status))
        return status

    def _sum(self):
        if self._thread is None:
            return ServoThreadStatus.from_buffer_copy(self._past)
        now = self._now()
        now.ticks += self._past.ticks
        now.missed += self._past.missed
        now.seen_flags |= self._past.seen_flags
        now.lateness.add(self._past.lateness)
        now.work.add(self._past.work)
        return now

    def status(self):
        """ServoThreadStatus, of all loops since the first start(); deadlines are status().lateness and .missed."""
        return self._sum()

    @property
    def lost(self):
        """Rows that found the ring full, so far."""
        return int(load().vxs_trace_dropped(self._trace))

    def rows(self):
        """The rows since the last call, oldest first: an array of ROW, a copy. Rows that were lost are missing from the column tick and
        counted in lost; a RuntimeWarning says so once for each loss."""
        parts = []
        while True:
            part = np.zeros(self._rows, dtype=ROW)
            count = load().vxs_trace_drain(self._trace, part.ctypes.data, len(part))
            parts.append(part[:count])
            if count < len(part):
                break
        lost = self.lost
        if lost > self._told:
            warnings.warn(f"{lost - self._told} rows lost: ask more often, or make the ring larger than {self._rows}", RuntimeWarning, stacklevel=2)
            self._told = lost
        return np.concatenate(parts)

    def check(self):
        """Raises ServoFault if the last tick ended in FAULT or had lost its device."""
        flags = ServoFlag(self.status().last_flags & ~0xFF)
        if flags & (ServoFlag.FAULT | ServoFlag.DEVICE_LOST):
            raise ServoFault(flags)

    def wait(self, seconds=None):
        """Until max_ticks are done (or stop() elsewhere), at most so long; whether they are. Raises ServoFault as check()."""
        end = None if seconds is None else time.monotonic() + seconds
        while self.running:
            self.check()
            if end is not None and time.monotonic() >= end:
                return False
            time.sleep(0.005)
        self.check()
        return True

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, kind, error, trace):
        self.stop()
        self.device.release()


def _end(process, thread, servo, device, _kept):
    if os.getpid() == process:  # a forked child has the memory, but not the thread
        load().vxs_servo_thread_stop(thread)
    servo.is_taken = device.is_taken = False
