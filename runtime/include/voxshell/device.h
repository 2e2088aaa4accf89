/* SPDX-License-Identifier: MIT
 *
 * device.h - a haptic device, whatever is behind it: pose in, wrench out.
 *
 * SI; frame right-handed, x right, y up, z to the user (glTF). Backends: one file each under
 * src/devices/, opened by a header of their own; `simulated` is always there and needs no
 * hardware (simulated.h).
 *
 * States: CLOSED -> READY (force off) -> ARMED -> READY ...; NO_FIRMWARE and UNCALIBRATED before
 * READY where a device needs it; FAULT and GONE from any. Force flows in ARMED only, and only
 * vxs_device_arm() arms: a device that comes back is READY.
 *
 * Every command carries two times. Until hold_ns the device renders all of it; from there it
 * decays linearly to zero at expires_ns: a loop that stalls or dies takes its force with it.
 */
#ifndef VOXSHELL_DEVICE_H
#define VOXSHELL_DEVICE_H

#include "voxshell/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* States. */
enum {
    VXS_DEVICE_CLOSED = 0,       /* not opened, or closed */
    VXS_DEVICE_NO_FIRMWARE = 1,  /* waits for its program (falcon) */
    VXS_DEVICE_UNCALIBRATED = 2, /* does not know where it is: home it */
    VXS_DEVICE_READY = 3,        /* pose is good, force is off */
    VXS_DEVICE_ARMED = 4,        /* pose is good, force flows */
    VXS_DEVICE_FAULT = 5,        /* cause in vxs_device_state.fault; vxs_device_disarm() returns to READY */
    VXS_DEVICE_GONE = 6          /* unplugged, for good: open it anew */
};

/* Causes of a FAULT. */
enum {
    VXS_DEVICE_FAULT_NONE = 0,     /* there is none */
    VXS_DEVICE_FAULT_USER = 1,     /* asked for: a button, an emergency stop */
    VXS_DEVICE_FAULT_VELOCITY = 2, /* faster than it may be, or a jump */
    VXS_DEVICE_FAULT_WATCHDOG = 3, /* one end did not hear of the other in time */
    VXS_DEVICE_FAULT_SOFTWARE = 4, /* not finite, or out of range */
    VXS_DEVICE_FAULT_USB = 5,      /* the wire */
    VXS_DEVICE_FAULT_DEADMAN = 6,  /* the switch under the hand was let go */
    VXS_DEVICE_FAULT_PROTOCOL = 7, /* packets against the protocol */
    VXS_DEVICE_FAULT_OVERRUN = 8   /* its own loop was too late */
};

/* Bits of the degree-of-freedom masks: x y z, turns about x y z, grip. */
enum { VXS_DEVICE_DOF_TRANSLATION = 7, VXS_DEVICE_DOF_ROTATION = 7 << 3, VXS_DEVICE_DOF_GRIP = 1 << 6 };

/* Where a velocity comes from: nowhere (0), the device, or differences of its positions. */
enum { VXS_DEVICE_VELOCITY_NONE = 0, VXS_DEVICE_VELOCITY_MEASURED = 1, VXS_DEVICE_VELOCITY_ESTIMATED = 2 };

/* What a device can do. 0 where it is not known. */
typedef struct vxs_device_caps {
    char name[48];                       /* "omega-3", for people */
    uint32_t dof_sensed, dof_actuated;   /* VXS_DEVICE_DOF_* */
    double rate_hz;                      /* nominal [Hz] */
    double peak_force, continuous_force; /* [N] */
    double peak_torque;                  /* [N m] */
    double max_stiffness;                /* [N/m], recommended closed loop */
    double max_damping;                  /* [N s/m] */
    double resolution;                   /* [m] */
    double mass, friction, viscosity;    /* felt at the tip [kg], [N], [N s/m] */
    uint32_t delay_samples;              /* between a command and its effect */
    uint32_t assumed;                    /* not 0: mass, friction and viscosity are assumptions */
    uint32_t has_watchdog;               /* in hardware */
    uint32_t verified;                   /* not 0: tried on hardware */
    uint32_t has_motors; /* not 0: what it renders pushes a hand; 0: simulated, or input only */
} vxs_device_caps;

/* View of one exchange, in. */
typedef struct vxs_device_state {
    uint64_t sequence;          /* grows by one per new measurement */
    int64_t time_ns;            /* host's monotonic clock, or virtual time */
    vxs_pose pose;              /* of its tip, device frame */
    double velocity[3];         /* [m/s] */
    double angular_velocity[3]; /* [rad/s] */
    uint32_t velocity_source;   /* VXS_DEVICE_VELOCITY_* */
    uint32_t buttons;           /* bit n: number n is down */
    uint32_t state;             /* VXS_DEVICE_* */
    uint32_t fault;             /* VXS_DEVICE_FAULT_* */
    double link_age;            /* of the measurement [s] */
} vxs_device_state;

/* One exchange, out. A command that is all 0 has expired: no force. */
typedef struct vxs_device_command {
    uint64_t sequence;  /* grows by one per command */
    vxs_wrench wrench;  /* on the hand, device frame */
    int64_t hold_ns;    /* full until then, */
    int64_t expires_ns; /* zero from then on; on the clock of vxs_device_state.time_ns */
} vxs_device_command;

/* What became of the command that is in effect. */
enum {
    VXS_DEVICE_CLAMPED = 1 << 0,    /* above the device's peak: one common factor on force, one on torque */
    VXS_DEVICE_DECAYING = 1 << 1,   /* past hold_ns */
    VXS_DEVICE_EXPIRED = 1 << 2,    /* past expires_ns: zero */
    VXS_DEVICE_INCOMPLETE = 1 << 3, /* part of the wrench is beyond the actuated degrees of freedom */
    VXS_DEVICE_REFUSED = 1 << 4     /* not finite: zero, and FAULT */
};

/* View of one exchange, back. */
typedef struct vxs_device_report {
    vxs_wrench rendered; /* what the motors were told */
    uint32_t flags;      /* VXS_DEVICE_CLAMPED ... */
} vxs_device_report;

/* Object: opened by its backend's header. One thread at a time. */
typedef struct vxs_device vxs_device;

/* What a backend implements. `self` is the memory that its opening call was given. */
typedef struct vxs_device_ops {
    const char *name; /* of the backend: "simulated" */
    /* set-up, may block: as vxs_device_arm(). */
    vxs_result (*arm)(void *self);
    /* set-up, may block: as vxs_device_disarm(). */
    vxs_result (*disarm)(void *self);
    /* set-up, may block: as vxs_device_close(). */
    void (*close)(void *self);
    /* rt-safe. Must not block, allocate, lock or log. Takes the newest command (NULL: the last one
     * goes on, and decays) and gives the newest measurement. report may be NULL. */
    void (*exchange)(void *self, const vxs_device_command *command, vxs_device_state *state,
                     vxs_device_report *report);
} vxs_device_ops;

/* The object, as its backend fills it. */
struct vxs_device {
    const vxs_device_ops *ops; /* what it does */
    void *self;                /* what ops are given */
    vxs_device_caps caps;      /* what it can do; does not change while it is open */
};

/* READY -> ARMED. VXS_OK (also if armed already); VXS_STATE from any other state; VXS_LOST.
 * Thread: set-up, not while another thread exchanges. */
VXS_API vxs_result vxs_device_arm(vxs_device *device);

/* ARMED or FAULT -> READY: force off. VXS_OK; VXS_STATE; VXS_LOST. Thread: as arm. */
VXS_API vxs_result vxs_device_disarm(vxs_device *device);

/* Force off and the end; NULL is allowed. Thread: as arm. */
VXS_API void vxs_device_close(vxs_device *device);

/* One exchange, as in vxs_device_ops. Thread: the servo's, rt-safe. */
VXS_API void vxs_device_exchange(vxs_device *device, const vxs_device_command *command,
                                 vxs_device_state *state, vxs_device_report *report);

/* The share 0 .. 1 of a command that is to be rendered at a time: for backends.
 * Thread: any, rt-safe. */
VXS_API double vxs_device_command_share(const vxs_device_command *command, int64_t now_ns);

/* The largest common factor <= 1 that brings the length of v down to limit (0: no limit).
 * Thread: any, rt-safe. */
VXS_API double vxs_device_clamp_factor(const double v[3], double limit);

#ifdef __cplusplus
}
#endif
#endif
