/* SPDX-License-Identifier: MIT
 *
 * plan.h - what a .plan file holds (formats/plan.md): a scene compiled for a device. Which assets (by name
 * and content hash), which constants of contact and coupling, which effects in their order of execution,
 * where the hand goes.
 */
#ifndef VOXSHELL_FORMAT_PLAN_H
#define VOXSHELL_FORMAT_PLAN_H

#include "voxshell/format/container.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_PLAN_VERSION_MAJOR = 1,       /* of the format */
    VXS_PLAN_VERSION_MINOR = 0,       /* of the format */
    VXS_PLAN_MAX_STATICS = 4096,      /* P301 */
    VXS_PLAN_MAX_EFFECTS = 64,        /* P401 */
    VXS_PLAN_MAX_CONSTANTS = 24,      /* of an effect */
    VXS_PLAN_MAX_KEYFRAMES = 1 << 16, /* P501, P601 */
    VXS_PLAN_NAME_SIZE = 256          /* of an asset's name, with the zero that ends it */
};

/* Largest |coordinate| of a position [m] (P208). */
#define VXS_PLAN_MAX_COORDINATE 1e15

/* Laws: ORIGINAL, AVERAGE, GRADIENT, PATCH as of the runtime's contact.h. */
enum {
    VXS_PLAN_LAW_ORIGINAL = 1,
    VXS_PLAN_LAW_AVERAGE = 2,
    VXS_PLAN_LAW_GRADIENT = 3,
    VXS_PLAN_LAW_PATCH = 4
};
/* Where a point's depth comes from (contact.h). */
enum { VXS_PLAN_FIELD_SURFACE = 1, VXS_PLAN_FIELD_LAYERS = 2, VXS_PLAN_FIELD_DISTANCE = 3 };
/* How points are weighted (contact.h). */
enum { VXS_PLAN_WEIGHT_COUNT = 1, VXS_PLAN_WEIGHT_COUNT_CAPPED = 2, VXS_PLAN_WEIGHT_AREA = 3 };
/* Couplings: NONE, PT2, SPRING_DAMPER, QUASI_STATIC as of the runtime's coupling.h. */
enum {
    VXS_PLAN_COUPLING_NONE = 1,
    VXS_PLAN_COUPLING_PT2 = 2,
    VXS_PLAN_COUPLING_SPRING_DAMPER = 3,
    VXS_PLAN_COUPLING_QUASI_STATIC = 4
};
enum { VXS_PLAN_FLAG_DESIGNED = 1 }; /* the coupling's numbers come from an automatic design */
/* What an asset is: a map that stands or follows keyframes, or the shell in the hand. */
enum { VXS_PLAN_ROLE_STATIC = 1, VXS_PLAN_ROLE_DYNAMIC = 2 };
/* How the hand comes to a keyframe: straight, or turning about an axis. */
enum { VXS_PLAN_MOVE_STRAIGHT = 0, VXS_PLAN_MOVE_TURN = 1 };

#define VXS_PLAN_SECTION_PLAN VXS_SECTION_ID('P', 'L', 'A', 'N') /* 1 x vxs_plan_info */
#define VXS_PLAN_SECTION_ASST                                                                                \
    VXS_SECTION_ID('A', 'S', 'S', 'T') /* vxs_plan_asset: statics, then the dynamic */
#define VXS_PLAN_SECTION_EFCT VXS_SECTION_ID('E', 'F', 'C', 'T') /* vxs_plan_effect, optional */
#define VXS_PLAN_SECTION_HAND VXS_SECTION_ID('H', 'A', 'N', 'D') /* vxs_plan_keyframe, optional */
#define VXS_PLAN_SECTION_MOVE VXS_SECTION_ID('M', 'O', 'V', 'E') /* vxs_plan_motion, optional */

/* The numbers of a scene. */
typedef struct vxs_plan_info {
    double rate; /* ticks a second [Hz] */
    /* contact */
    uint32_t law, field, weighting; /* VXS_PLAN_LAW_, _FIELD_, _WEIGHT_ */
    uint32_t flags;                 /* VXS_PLAN_FLAG_* */
    double stiffness;               /* [N/m] per point, [N/m^3] with weighting area */
    double most_stiffness;          /* [N/m], 0: no bound */
    double budget;                  /* of contact in a tick [s], 0: none */
    /* coupling; what its kind has not is 0 */
    uint32_t coupling;    /* VXS_PLAN_COUPLING_* */
    uint32_t prewarp;     /* not 0: Tustin exact at omega0 */
    uint32_t evaluations; /* of contact in a tick at most */
    uint32_t reserved;
    double omega0;             /* [rad/s] */
    double damping;            /* [1] */
    double gain;               /* [1] */
    double coupling_stiffness; /* [N/m] */
    double radius;             /* [m] */
    double mass;               /* [kg] */
    /* servo */
    double max_force;            /* [N] */
    double max_torque;           /* [N m] */
    double max_speed;            /* [m/s] */
    double hold_time;            /* [s], 0: two samples */
    double decay_time;           /* [s] */
    double scale;                /* scene metres per device metre [1] */
    double mount_position[3];    /* [m]; device -> scene */
    double mount_orientation[4]; /* w x y z; device -> scene */
    double grip_position[3];     /* [m]; shell -> tip */
    double grip_orientation[4];  /* w x y z; shell -> tip */
    uint8_t device[48];          /* "sim:phantom-premium-1.5" */
    uint8_t arm[16];             /* "hand" */
    uint8_t pad[48];             /* 0 */
} vxs_plan_info;

/* An asset that a scene needs. */
typedef struct vxs_plan_asset {
    uint32_t role;                    /* VXS_PLAN_ROLE_* */
    uint32_t reserved;                /* 0 */
    double position[3];               /* [m]; asset -> scene */
    double orientation[4];            /* w x y z; asset -> scene */
    uint8_t content_hash[32];         /* of the asset (container.md) */
    uint8_t name[VXS_PLAN_NAME_SIZE]; /* file name, beside the plan */
    uint8_t pad[32];                  /* 0 */
} vxs_plan_asset;

/* An effect of the tick, by its name. */
typedef struct vxs_plan_effect {
    uint8_t kind[32];                         /* name: "soft-start" */
    uint32_t constant_count;                  /* of constants */
    uint32_t reserved;                        /* 0 */
    double constants[VXS_PLAN_MAX_CONSTANTS]; /* in the kind's order and SI units [1]; the others are 0 */
} vxs_plan_effect;

/* Where the hand is at a time. */
typedef struct vxs_plan_keyframe {
    double time;           /* [s] */
    double position[3];    /* [m] */
    double orientation[4]; /* w x y z */
    uint32_t move;         /* VXS_PLAN_MOVE_*: how it is reached */
    uint32_t reserved;     /* 0 */
    double turn_about[3];  /* [m], of a turn, else 0 */
    double turn_axis[3];   /* of length 1, of a turn, else 0 */
    double turn_angle;     /* [rad], of a turn, else 0 */
} vxs_plan_keyframe;

/* Where a static is at a time. */
typedef struct vxs_plan_motion {
    double time;           /* [s] */
    double position[3];    /* [m] */
    double orientation[4]; /* w x y z */
    uint32_t asset;        /* number of the static in ASST */
    uint32_t reserved;     /* 0 */
} vxs_plan_motion;

VXS_STATIC_ASSERT(sizeof(vxs_plan_motion) == 72, "motion is 72 bytes");
VXS_STATIC_ASSERT(sizeof(vxs_plan_info) == 384, "info is 384 bytes");
VXS_STATIC_ASSERT(offsetof(vxs_plan_info, coupling) == 48, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_plan_info, max_force) == 112, "layout");
VXS_STATIC_ASSERT(offsetof(vxs_plan_info, device) == 272, "layout");
VXS_STATIC_ASSERT(sizeof(vxs_plan_asset) == 384, "asset is 384 bytes");
VXS_STATIC_ASSERT(sizeof(vxs_plan_effect) == 232, "effect is 232 bytes");
VXS_STATIC_ASSERT(sizeof(vxs_plan_keyframe) == 128, "keyframe is 128 bytes");

#ifdef __cplusplus
}
#endif
#endif
