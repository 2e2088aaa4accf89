/* SPDX-License-Identifier: MIT
 *
 * emulated.h - devices that are not there: a mass in a hand (the simulated device), a device's own end of its
 * protocol and its kinematics, and a wire on virtual time that can be cut, delayed, and lie.
 */
#ifndef VXS_TEST_EMULATED_H
#define VXS_TEST_EMULATED_H

#include "devices/falcon_protocol.h"
#include "devices/haply_kinematics.h"
#include "devices/haply_protocol.h"
#include "devices/link.h"
#include "devices/spacemouse_protocol.h"
#include "voxshell/hvlink.h"
#include "voxshell/simulated.h"

enum { EMULATED_QUEUE = 64, EMULATED_PACKET = 256 };

/* What goes wrong with a packet, in parts of 65536 of all; and once. */
typedef struct emulated_trouble {
    uint32_t lost, doubled, damaged, delayed, split, random, not_finite, jump;
    uint32_t unplug_at; /* the wire's call of this number finds nobody, nor does any after; 0: never */
} emulated_trouble;

typedef struct emulated emulated;
typedef struct emulated_kind {
    const char *name;
    const vxsi_driver *driver;
    void (*hear)(emulated *e, const uint8_t *bytes, size_t size); /* from the host */
    void (*sample)(emulated *e);                                  /* once a millisecond, may say something */
    int has_force;
} emulated_kind;

struct emulated {
    const emulated_kind *kind;
    int64_t now_ns;
    emulated_trouble trouble;
    uint64_t random;
    uint32_t calls; /* of the wire */
    uint32_t is_closed, is_silent;
    struct {
        uint8_t bytes[EMULATED_PACKET];
        size_t size;
        int64_t due_ns;
    } queue[EMULATED_QUEUE];
    uint32_t first, count;

    uint8_t memory[1 << 13] __attribute__((aligned(64)));
    vxs_device *tip;
    double hand[3];
    double place[3]; /* of the tip, encoded */
    double force[3]; /* that the motors make at the tip, device frame */
    uint64_t heard;  /* packets with a force, that got here whole */
    int64_t last_heard_ns;

    vxsi_falcon_stream stream; /* falcon */
    uint32_t has_firmware, is_homed, baud, uploaded, bad_uploads;
    vxsi_pantograph pantograph; /* haply */
    vxsi_haply_setup board;     /* as it was told */
    vxs_hvlink_device hvlink;   /* and the others' */
    vxsi_spacemouse_axes axes;
    uint32_t tick;
};

extern const emulated_kind emulated_falcon, emulated_haply, emulated_hvlink, emulated_spacemouse;
extern const emulated_kind *const emulated_kinds[4];

/* At rest, held by a hand, firmware there and homed, no trouble. */
void emulated_init(emulated *e, const emulated_kind *kind);

/* The same, held otherwise, with Coulomb friction [N] at the tip. */
void emulated_init_held(emulated *e, const emulated_kind *kind, const vxs_simulated_arm *arm,
                        double friction);
vxsi_wire emulated_wire(emulated *e);
int64_t emulated_now(void *e);

/* A link to it, on its clock, without a thread. */
vxs_result emulated_link(emulated *e, vxsi_link *link);
vxs_result emulated_link_as(emulated *e, vxsi_link *link, const vxs_hardware_config *config);

/* A millisecond: the link's turns, then the mass moves. */
void emulated_run(emulated *e, vxsi_link *link);

/* The device frame's length of the motors' force [N]. */
double emulated_force(const emulated *e);

#endif
