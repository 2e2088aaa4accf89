/* SPDX-License-Identifier: MIT
 *
 * effect.h - what a scene may ask of the servo's tick beyond contact and coupling.
 *
 * The tick is a list of stages that vxs_servo_init() resolves: contact, coupling and clamp are always
 * in it, an effect only if the config lists it. What is not listed costs nothing. The order is the
 * table's (src/servo_table.c), whatever the order of the config's list:
 *
 *     motion -> contact -> start-inside -> contact-damping -> friction -> gravity -> viscosity -> proximity
 *     -> workspace -> inertia -> coupling (torque) -> passivity -> slew -> clamp -> soft-start
 *
 * What touching does goes through the coupling: contact's wrench, what contact-damping makes of it, and
 * friction. What acts on the object besides (gravity, viscosity, proximity) moves its body where it has one
 * (spring-damper), else it acts on the hand as it is: a filter that is there for contact would only delay
 * it. The object's velocity is measured from one tick's pose to the next, at the middle of the shell's
 * bounding sphere: 0 in the first tick after arming.
 *
 * Forces:
 *   CONTACT_DAMPING  Hunt and Crossley (1975): the wrench of contact F_e, M_e times a factor,
 *                     F = F_e (1 + c v_n),  the factor at least 0 and at most `most`.
 *                 v_n [m/s] is the speed of approach along the force: -(F_e . v + M_e . w) / N, M_e about
 *                 the middle, N the larger of |F_e| and |M_e| / (the shell's radius). Contact that pushes
 *                 one way has N = |F_e|. It never pulls, never gives energy, and begins and ends with F_e.
 *                 A mass that hits at v leaves at u with c v - ln(1 + c v) = -c u - ln(1 - c u), whatever
 *                 the mass and the law of F_e: a restitution of u / v = 1 - 2/3 c v + O((c v)^2).
 *   FRICTION      Coulomb's, with presliding. Each load of the contact (contact.h: by static and direction,
 *                 with normal force N_i, centre, normal and radius r_i) has an anchor, and s_i, how far the
 *                 object has moved from it along the tangent plane, and by the twist about the normal
 *                 times r_i: the fourth component. With w_i = N_i / sum N, the object feels at the centre
 *                     F_i = -w_i (k_t s_i + b_t s_i')        (and the torque r_i F_i4 about the normal)
 *                 while |F_i| <= mu_s N_i. Beyond it the anchor is dragged along, so that |F_i| = mu_k N_i,
 *                 until it takes less to hold; contact-damping scales N too. An anchor goes with its
 *                 static. What one anchor loses of its share w goes, stretch and all, to those that gain:
 *                 nothing jumps where contact passes from one direction to the next; the last load that
 *                 goes takes it all. In no tick does it give more than it had:
 *                     -F . dx >= U - U_before,   U = k_t/2 sum w_i |s_i|^2,
 *                 dx the way of each centre's material point in the tick: the return to the cone is that
 *                 of plasticity, a mean's square is no more than the mean of squares, turning keeps
 *                 lengths. A command that a device holds over a sample gives what any spring does: k_t and
 *                 b_t count in the loop like contact's stiffness and a damping.
 *   INERTIA       the object is a rigid body (mass, centre of mass, inertia) that what touches it, weight and
 *                 drag move, and that hangs on the device by a spring and a damper at its tip, turning
 *                 by stiffness x radius^2; the device feels that spring, through a coupling `none` or
 *                 `pt2` (another one has a body itself: VXS_TWO_BODIES). stiffness 0: it is free. Each
 *                 tick kicks it, then lets it drift; the spring is implicit, which is stable however
 *                 stiff. A free body keeps energy and momentum to rounding, about every axis (Simo and
 *                 Wong 1991), for turns up to 1 rad a tick, at which it is held. The way has an error of
 *                 the order T^2. What pushes it from outside is explicit: with C = the largest eigenvalue
 *                 of the inverse mass at the tip [1/kg] (1/m of a ball that is gripped in its middle),
 *                 contact is bounded by most_stiffness = 1 / (4 C T^2) where the config does not say less,
 *                 and an effect (friction, viscosity, proximity) is refused (VXS_TOO_STIFF) whose
 *                 (k_t + b_t / T) (1 + a^2) C T^2 is above 1, a the reach of the shell from the tip over its
 *                 radius: 1 where the tip is in its middle.
 *   GRAVITY       the object's weight: mass times acceleration, at the centre of mass. Conservative.
 *   VISCOSITY     Stokes' drag of a medium: force -damping v at the middle, torque -turning w. A command is
 *                 held over the sample T, so it damps a felt mass m only below 2 m / T without a delay, and
 *                 below about m / (T (d + 1/2)) with one of d samples: a bound of the device.
 *   PROXIMITY     a brake before contact. Each point of the shell whose signed distance D from a static, by
 *                 the map's channel, is within +-reach has a weight w = (1 - |D| / reach)^2 and slows what of
 *                 its velocity leads down the gradient g of D:
 *                     F = damping (max w) (sum w max(0, -g . v) g) / (sum w),  torque accordingly.
 *                 So an object that comes near at v, not turning, feels damping (1 - gap / reach)^2 v. It
 *                 brakes approach only, never pulls, and nothing jumps where another point comes to be the
 *                 nearest. It is there in contact, too, and fades where all points are deep. Bounds as of
 *                 viscosity. Needs a signed distance channel with a band of reach at least (VXS_CHANNEL).
 *                 Some 100 instructions a point in the clusters within reach: most_points does not count it.
 *   WORKSPACE     walls around the tip: a side of a box, fixed in the scene, that the tip is beyond by d
 *                 pushes it back with max(0, stiffness d + damping v min(1, d / 1 mm)), v its speed outwards.
 *                 On the hand, whatever the coupling; its stiffness is in the device's loop as contact's is.
 *   TORQUE        the hand feels torque: the coupling's other three axes, clamped by max_torque. Without it
 * the command's torque is 0, as for a device of three degrees of freedom; forces are the same to the last
 * bit. Contact sums its torque all the same: it turns bodies, and a tick would only be 1 to 2 % shorter
 * without.
 *
 * Scene:
 *   MOTION        statics follow keyframes from the first tick on that gives force. Before it they rest at
 *                 their first one, and after the last one there, or with `loop` they begin again. Between
 *                 two keyframes the position is on the straight line, in proportion to time, and the
 *                 orientation is the normalised sum of both quaternions weighted by time, the short way
 *                 round: on the arc between them, within 0.12 degrees of an even pace for two that are 45
 *                 degrees apart, 0.95 for 90. Time counts ticks: a late one makes no jump. A velocity that
 *                 contact-damping looks at is then relative to what is touched.
 *
 * Guards:
 *   START_INSIDE  armed inside or touching the scene: zero force and VXS_SERVO_START_IN_CONTACT until
 *                 the object was free once.
 *   PASSIVITY     the time-domain passivity observer and controller of Hannaford and Ryu (2002), in its
 *                 position form: the energy that the tick has taken from the hand,
 *                     E_k = E_(k-1) - f_(k-1-d) . (x_k - x_(k-1)),
 *                 is exact for a command f that a device holds over a sample, d samples late, as long as
 *                 every tick has a new measurement. It counts what was commanded: after slew, clamp and
 *                 ramp. If E would be below zero once the commands under way and this one have acted, the
 *                 motion going on as in the last sample, a damping takes what is missing:
 *                     f -= a v,  a = -E T / |x_k - x_(k-1)|^2, at most most_damping.
 *                 Turning adds torque . turn to the energy; |v|^2 is then v^2 + radius^2 w^2 and the
 *                 torque damped by a radius^2 w. Uncapped, and no slower than least_speed, E stays above
 *                     -F A T^2 (d+1)(d+2)/2
 *                 for commands up to F [N] and accelerations up to A [m/s^2], encoder noise included. The
 *                 damping itself never gives more than most_damping |v| |x_(k+1+d) - x_(k+d)| in a
 *                 sample, where the hand turned round; that is observed too. What was taken may be given
 *                 back until nothing touches and the wrench is below 1 uN; then it is forgotten (a
 *                 deficit is not).
 *   SLEW          the limit of snaps: the wrench changes no faster than a rate, force and torque each along
 *                 a straight line.
 *   SOFT_START    the wrench is multiplied by a gain that grows from 0 to 1 over `time` from arming on.
 *                 After missed ticks it goes on from the share that the device still rendered.
 */
#ifndef VOXSHELL_EFFECT_H
#define VOXSHELL_EFFECT_H

#include "voxshell/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_EFFECT_START_INSIDE = 1,
    VXS_EFFECT_PASSIVITY = 2,
    VXS_EFFECT_SLEW = 3,
    VXS_EFFECT_SOFT_START = 4,
    VXS_EFFECT_FRICTION = 5,
    VXS_EFFECT_CONTACT_DAMPING = 6,
    VXS_EFFECT_VISCOSITY = 7,
    VXS_EFFECT_GRAVITY = 8,
    VXS_EFFECT_INERTIA = 9,
    VXS_EFFECT_PROXIMITY = 10,
    VXS_EFFECT_WORKSPACE = 11,
    VXS_EFFECT_TORQUE = 12,
    VXS_EFFECT_MOTION = 13,
    VXS_EFFECT_OWN = 1000 /* a program's: vxs_effect.own (effect_kind.h, samples/own_effect) */
};

/* Most of: passivity's delay [samples], constants of a kind, keyframes of an effect. */
enum { VXS_EFFECT_MAX_DELAY = 64, VXS_EFFECT_MAX_CONSTANTS = 24, VXS_EFFECT_MAX_KEYFRAMES = 1 << 20 };

/* Where a static is at a time. */
typedef struct vxs_effect_keyframe {
    double time;           /* [s] >= 0 */
    vxs_pose pose;         /* map frame -> scene frame, in place of the static's own */
    uint32_t static_index; /* which static, by its number in the config */
    uint32_t reserved;     /* 0 */
} vxs_effect_keyframe;

/* Config of one effect: filled by vxs_effect_default(). Its constants have names for C, and are one array in
 * the order of vxs_effect_constants() for files and tables. */
typedef struct vxs_effect {
    uint32_t struct_size;
    uint32_t kind; /* VXS_EFFECT_* */
    union {
        double constants[VXS_EFFECT_MAX_CONSTANTS]; /* each in its unit [1]; beyond the kind's they are 0 */
        struct {
            double most_damping; /* [N s/m] > 0; default 5. Above about m / (T (d + 1/2)) of the felt mass m
                                    it shakes by itself; a device's caps say what it recommends */
            double least_speed;  /* [m/s] >= 0, below it nothing is damped; default 0.001 */
            double radius;       /* [m] >= 0, of turning; 0 (default), or without TORQUE: turning is neither
                                    counted nor damped */
            double delay; /* d [samples], whole, 0 .. VXS_EFFECT_MAX_DELAY: caps.delay_samples; default 1 */
        } passivity;
        struct {
            double force;  /* [N/s] >= 0; 0 (default): from zero to max_force in 4 ms */
            double torque; /* [N m/s] >= 0; 0 (default): from zero to max_torque in 4 ms */
        } slew;
        struct {
            double time; /* [s] >= 0; default 0.5 */
        } soft_start;
        struct {
            double factor; /* c [s/m] >= 0; default 1 */
            double most;   /* [1] >= 1, of the factor on F_e; default 4 */
        } contact_damping;
        struct {
            double damping; /* [N s/m] >= 0; default 1 */
            double turning; /* [N m s/rad] >= 0; default 0 */
        } viscosity;
        struct {
            double mass;            /* [kg] >= 0; default 0.1 */
            double com[3];          /* centre of mass, shell's frame [m]; default 0 */
            double acceleration[3]; /* scene's frame [m/s^2]; default 0, -9.80665, 0 */
        } gravity;
        struct {
            double sticking;  /* mu_s, 0 .. 10; default 0.4 */
            double sliding;   /* mu_k, 0 .. mu_s; default 0.3 */
            double stiffness; /* k_t of the whole contact [N/m] > 0; default 1000 */
            double damping;   /* b_t of the whole contact while it sticks [N s/m] >= 0; default 1 */
        } friction;
        struct {
            double mass;       /* [kg] > 0; default 0.05 */
            double com[3];     /* centre of mass in the shell's frame [m]; default 0 */
            double inertia[6]; /* about it, along the shell's axes: xx yy zz xy xz yz [kg m^2], xy = -sum m x
                                  y. Default: of a ball of that mass and a radius of 20 mm */
            double stiffness;  /* of the spring to the device [N/m] >= 0; default 1000; 0: a free body */
            double damping;    /* its zeta [1] >= 0; default 1 */
            double radius;     /* about an axis stiffness x radius^2 [m] > 0; default 0.02 */
        } inertia;
        struct {
            double damping; /* at contact [N s/m] >= 0; default 5 */
            double reach;   /* [m] > 0; default 0.003 */
        } proximity;
        struct {
            double low[3], high[3]; /* the box, low < high [m]; default -0.1, 0.1 */
            double stiffness;       /* [N/m] >= 0; default 500 */
            double damping;         /* [N s/m] >= 0; default 2 */
        } workspace;
        struct {
            double loop; /* 0 .. 1, a switch. 1: each static begins again at its last keyframe's
                            time; 0 (default): it rests */
        } motion;
    } as;
    /* MOTION: 1 .. VXS_EFFECT_MAX_KEYFRAMES of all statics that move, in order of the static and then of
     * time, no two of a static at one time; borrowed until the servo's last tick. NULL and 0 for other kinds.
     */
    const vxs_effect_keyframe *keyframes;
    uint32_t keyframe_count;           /* of keyframes */
    uint32_t reserved;                 /* 0 */
    const struct vxs_effect_kind *own; /* of VXS_EFFECT_OWN, by vxs_effect_own(); NULL for other kinds */
} vxs_effect;

/* One constant of a kind. */
typedef struct vxs_effect_constant {
    const char *name;   /* as in the struct above and in a scene file; a vector's end in _x, _y, _z */
    const char *unit;   /* "N/s"; "" for a plain number */
    double standard;    /* by default [unit] */
    double least, most; /* its range [unit], finite */
} vxs_effect_constant;

/* The constants of a kind in their order, *count of them; NULL and 0 for no such kind or none. Ownership:
 * static. Thread: any, rt-safe. */
VXS_API const vxs_effect_constant *vxs_effect_constants(uint32_t kind, uint32_t *count);

/* VXS_OK; VXS_PARAM for no such kind (effect untouched). Thread: any, rt-safe. */
VXS_API vxs_result vxs_effect_default(uint32_t kind, vxs_effect *effect);

/* VXS_OK; VXS_CONFIG; VXS_PARAM (no such kind, an own one as vxs_effect_own(), a number out of its range, one that the kind does not have not
 * 0, keyframes). Thread: any, set-up. */
VXS_API vxs_result vxs_effect_check(const vxs_effect *effect);

/* Name of a kind ("start-inside", "contact-damping"), NULL for none such; and back, 0 for none such.
 * Ownership: static. Thread: any, rt-safe. */
VXS_API const char *vxs_effect_kind_name(uint32_t kind);
VXS_API uint32_t vxs_effect_kind_named(const char *name);

/* Kinds in order of execution, from number 0 on; 0 at the end. Thread: any, rt-safe. */
VXS_API uint32_t vxs_effect_kind_at(uint32_t index);

/* Not 0 for a guard: it protects the hand, and only takes away from what is felt or delays it. A scene lists
 * these by themselves. Thread: any, rt-safe. */
VXS_API int vxs_effect_is_guard(uint32_t kind);

#ifdef __cplusplus
}
#endif
#endif
