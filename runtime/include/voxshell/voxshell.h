/* SPDX-License-Identifier: MIT
 *
 * voxshell.h - all of the runtime. Each header is the manual of its noun.
 */
#ifndef VOXSHELL_VOXSHELL_H
#define VOXSHELL_VOXSHELL_H

#include "voxshell/asset.h"
#include "voxshell/contact.h"
#include "voxshell/coupling.h"
#include "voxshell/device.h"
#include "voxshell/pointshell.h"
#include "voxshell/pose.h"
#include "voxshell/result.h"
#include "voxshell/servo.h"
#include "voxshell/servo_thread.h"
#include "voxshell/simulated.h"
#include "voxshell/trace.h"
#include "voxshell/voxmap.h"

#endif
