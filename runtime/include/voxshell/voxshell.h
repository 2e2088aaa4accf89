/* SPDX-License-Identifier: MIT
 *
 * voxshell.h - all of the runtime. Each header is the manual of its noun.
 */
#ifndef VOXSHELL_VOXSHELL_H
#define VOXSHELL_VOXSHELL_H

#include "voxshell/asset.h"
#include "voxshell/contact.h"
#include "voxshell/coupling.h"
#include "voxshell/coupling_kind.h"
#include "voxshell/device.h"
#include "voxshell/effect.h"
#include "voxshell/effect_kind.h"
#include "voxshell/live.h"
#include "voxshell/plan.h"
#include "voxshell/pointshell.h"
#include "voxshell/pose.h"
#include "voxshell/recorder.h"
#include "voxshell/result.h"
#include "voxshell/servo.h"
#include "voxshell/servo_thread.h"
#include "voxshell/simulated.h"
#include "voxshell/trace.h"
#include "voxshell/voxmap.h"

/* Of the library; the formats have versions of their own (formats/README.md). */
#define VXS_VERSION_MAJOR 0 /* programs are to be changed */
#define VXS_VERSION_MINOR 1 /* before 1.0: programs are to be compiled anew */
#define VXS_VERSION_PATCH 0 /* nothing is to be done */

#ifdef __cplusplus
extern "C" {
#endif

/* Major << 16 | minor << 8 | patch of the library that is linked. Thread: any, rt-safe. */
VXS_API uint32_t vxs_version(void);

#ifdef __cplusplus
}
#endif
#endif
