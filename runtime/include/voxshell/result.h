/* SPDX-License-Identifier: MIT
 *
 * result.h - what a set-up call returns, and the export macro.
 *
 * Set-up calls return a vxs_result: 0 or negative. Calls of the tick cannot fail: they
 * return flags (contact.h, servo.h). The library never prints and never aborts.
 */
#ifndef VOXSHELL_RESULT_H
#define VOXSHELL_RESULT_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
/* What the library exports. */
#define VXS_API __attribute__((visibility("default")))
#else
#define VXS_API /* nothing to say to other compilers */
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The one list: name, value, text. Values are pinned for ever; each family has room. */
#define VXS_RESULT_LIST(X)                                                                                   \
    X(OK, 0, "ok")                                                                                           \
    X(PARAM, -1, "an argument is null or out of its range")                                                  \
    X(STATE, -2, "the call does not fit the object's state")                                                 \
    X(BUFFER, -3, "the memory given is too small or not aligned")                                            \
    X(UNSUPPORTED, -4, "not supported by this build, device or machine")                                     \
    X(CONFIG, -5, "the config was not filled by its _default function (struct_size)")                        \
    X(IO, -20, "the file cannot be opened or read")                                                          \
    X(MAGIC, -21, "not a voxshell asset")                                                                    \
    X(KIND, -22, "a voxshell asset, but of another kind than asked for")                                     \
    X(VERSION, -23, "written by a newer major version of the format")                                        \
    X(FEATURE, -24, "needs a feature that this reader does not know")                                        \
    X(TRUNCATED, -25, "shorter or longer than its header says")                                              \
    X(CHECKSUM, -26, "a checksum does not match: the file is damaged")                                       \
    X(CORRUPT, -27, "breaks a rule of its format")                                                           \
    X(LIMIT, -28, "exceeds a documented limit")                                                              \
    X(PLAN, -29, "the plan was made for other assets than these")                                            \
    X(NO_DEVICE, -40, "no such device")                                                                      \
    X(ACCESS, -41, "the device is here but may not be used by this user")                                    \
    X(BUSY, -42, "the device is in use by another program")                                                  \
    X(TIMEOUT, -43, "the device did not answer in time")                                                     \
    X(PROTOCOL, -44, "the device answered against its protocol")                                             \
    X(LOST, -45, "the device is gone")                                                                       \
    X(FREQUENCY, -60, "coupling: natural frequency outside 0.05 Hz .. 0.49 / sample time")                   \
    X(DAMPING, -61, "coupling: damping ratio outside 0.001 .. 1000")                                         \
    X(SAMPLE_TIME, -62, "coupling: sample time outside 1e-5 .. 0.1 s")                                       \
    X(GAIN, -63, "coupling: gain not finite or not positive")                                                \
    X(IMPEDANCE, -64, "coupling: stiffness, damping, mass or radius not finite or not positive")             \
    X(LAW_FIELD, -70,                                                                                        \
      "contact: the law gradient takes its direction from the field distance, and from no other")            \
    X(CHANNEL, -71, "contact: a map has not got the channel that the field needs")                           \
    X(TWO_BODIES, -72, "servo: inertia makes the object a body, and so does the coupling: take none or pt2") \
    X(TOO_STIFF, -73,                                                                                        \
      "servo: an effect is stiffer, or damps more, than the object's inertia bears at this sample time")     \
    X(NO_AREA, -74, "contact: the shell has no areas, by which to weigh points or levels of detail")         \
    X(UNGUARDED, -75,                                                                                        \
      "servo: a device with motors is not driven without the guards start-inside and soft-start")            \
    X(NO_THREAD, -80, "the servo thread could not be started")

/* 0 or negative; the list has their texts. */
typedef enum vxs_result {
/* One of them. */
#define VXS_RESULT_ENUM(name, value, text) VXS_##name = value,
    VXS_RESULT_LIST(VXS_RESULT_ENUM)
#undef VXS_RESULT_ENUM
} vxs_result;

/* "VXS_CORRUPT" for VXS_CORRUPT; "VXS_?" for a value that is none.
 * Ownership: static storage. Thread: any, rt-safe. */
VXS_API const char *vxs_result_name(vxs_result result);

/* One line for people, lower case, no full stop. Ownership: static. Thread: any, rt-safe. */
VXS_API const char *vxs_result_text(vxs_result result);

#ifdef __cplusplus
}
#endif
#endif
