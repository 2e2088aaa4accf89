/* SPDX-License-Identifier: MIT
 *
 * vector.h - private: products of three-vectors and of rotation matrices (row by row), each sum in one fixed
 * order. out may be an argument.
 */
#ifndef VXSI_VECTOR_H
#define VXSI_VECTOR_H

static inline double vxsi_dot(const double a[3], const double b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

static inline void vxsi_cross(const double a[3], const double b[3], double out[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x, out[1] = y, out[2] = z;
}

/* r v. */
static inline void vxsi_rotate(const double r[9], const double v[3], double out[3])
{
    const double x = vxsi_dot(r, v), y = vxsi_dot(r + 3, v), z = vxsi_dot(r + 6, v);
    out[0] = x, out[1] = y, out[2] = z;
}

/* r^T v. */
static inline void vxsi_rotate_back(const double r[9], const double v[3], double out[3])
{
    double turned[3];
    for (int i = 0; i < 3; i++) turned[i] = (r[i] * v[0] + r[3 + i] * v[1]) + r[6 + i] * v[2];
    for (int i = 0; i < 3; i++) out[i] = turned[i];
}

#endif
