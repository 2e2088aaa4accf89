/* SPDX-License-Identifier: MIT */
#include "falcon_kinematics.h"

#include <math.h>
#include <string.h>

/* [m], [rad] */
static const double a = 0.060, b = 0.1025, c = 0.01443, d = 0.01125, e = 0.01125, f = -0.025, r = 0.040,
                    s = -0.02309;
static const double degree = 0.017453292519943295;
static const double leg_degrees[3] = {105, -15, -135};
/* 1280 counts a turn of a shaft of 14.25 mm on an arm of 110 mm */
static const double rest_degrees = 35, degrees_per_count = 0.036434659;
static const double middle[3] = {0, 0, 0.12};

/* A place within reach takes 75 inverses at most, from the middle: more is none. */
enum { MOST_TRIES = 100, MOST_HALVINGS = 30 };

double vxsi_falcon_angle(int16_t count)
{
    return (rest_degrees + count * degrees_per_count) * degree;
}

int16_t vxsi_falcon_count(double angle)
{
    double count = floor((angle / degree - rest_degrees) / degrees_per_count + 0.5);
    return (int16_t)(count > 32767 ? 32767 : count < -32768 ? -32768 : count);
}

/* Leg: th1 at the shoulder, th2 at the elbow, th3 the parallelogram's tilt. With u, v, w the tip in the leg's
 * frame: v + f = b cos th3,   u + c = a cos th1 + L cos th2,   w = a sin th1 + L sin th2,   L = d + e + b sin
 * th3 Elimination of th2 leaves a quadratic in tan(th1 / 2); of its roots the one with the elbow outside. */
static int leg(double u, double v, double w, double *angle, double slope[3])
{
    double tilt = (v + f) / b;
    if (!(tilt > -1 && tilt < 1)) return 0;
    double sin3 = sqrt(1 - tilt * tilt), length = d + e + b * sin3, along = u + c;
    double k = w * w + along * along + a * a - length * length;
    double l0 = k - 2 * a * along, l1 = -4 * a * w, l2 = k + 2 * a * along;
    double root = l1 * l1 - 4 * l0 * l2;
    if (!(root >= 0) || l2 == 0) return 0;
    double th1 = 2 * atan((-l1 - sqrt(root)) / (2 * l2)); /* -pi .. pi */
    double cos2 = (along - a * cos(th1)) / length, sin2 = (w - a * sin(th1)) / length;
    double lever = a * sin3 * (sin2 * cos(th1) - cos2 * sin(th1));
    if (!(fabs(lever) > 1e-9)) return 0;
    *angle = th1;
    slope[0] = cos2 * sin3 / lever;
    slope[1] = tilt / lever;
    slope[2] = sin2 * sin3 / lever;
    return 1;
}

int vxsi_falcon_inverse(const double place[3], double angle[3], double jacobian[9])
{
    double angles[3], rows[9];
    for (int n = 0; n < 3; n++) {
        double cosine = cos(leg_degrees[n] * degree), sine = sin(leg_degrees[n] * degree), slope[3];
        double u = cosine * place[0] + sine * place[1] - r, v = -sine * place[0] + cosine * place[1] - s;
        if (!leg(u, v, place[2], &angles[n], slope)) return 0;
        rows[3 * n] = cosine * slope[0] - sine * slope[1];
        rows[3 * n + 1] = sine * slope[0] + cosine * slope[1];
        rows[3 * n + 2] = slope[2];
    }
    memcpy(angle, angles, sizeof angles);
    if (jacobian) memcpy(jacobian, rows, sizeof rows);
    return 1;
}

/* x of m x = y (row by row, or of its transpose), by Cramer's rule. */
static int solve(const double m[9], int is_transposed, const double y[3], double x[3])
{
    double t[9];
    for (int i = 0; i < 9; i++) t[i] = is_transposed ? m[i % 3 * 3 + i / 3] : m[i];
    double c0 = t[4] * t[8] - t[5] * t[7], c1 = t[5] * t[6] - t[3] * t[8], c2 = t[3] * t[7] - t[4] * t[6];
    double det = t[0] * c0 + t[1] * c1 + t[2] * c2;
    if (!(fabs(det) > 1e-6)) return 0;
    x[0] = (c0 * y[0] + (t[2] * t[7] - t[1] * t[8]) * y[1] + (t[1] * t[5] - t[2] * t[4]) * y[2]) / det;
    x[1] = (c1 * y[0] + (t[0] * t[8] - t[2] * t[6]) * y[1] + (t[2] * t[3] - t[0] * t[5]) * y[2]) / det;
    x[2] = (c2 * y[0] + (t[1] * t[6] - t[0] * t[7]) * y[1] + (t[0] * t[4] - t[1] * t[3]) * y[2]) / det;
    return isfinite(fabs(x[0]) + fabs(x[1]) + fabs(x[2]));
}

static double most_of(const double v[3])
{
    return fmax(fmax(fabs(v[0]), fabs(v[1])), fabs(v[2]));
}

static int newton(const double angle[3], double place[3])
{
    double at[3], have[3], jacobian[9], miss[3], step[3];
    memcpy(at, place, sizeof at);
    if (!vxsi_falcon_inverse(at, have, jacobian)) return 0;
    for (int n = 0; n < 3; n++) miss[n] = angle[n] - have[n];
    for (int tries = 0; tries < MOST_TRIES;) {
        double worst = most_of(miss);
        if (worst <= 1e-12) {
            memcpy(place, at, sizeof at);
            return 1;
        }
        if (!solve(jacobian, 0, miss, step)) return 0;
        double share = most_of(step) > 0.02 ? 0.02 / most_of(step) : 1;
        for (int halved = 0;; halved++, share /= 2) {
            double next[3], trial[3], rows[9], left[3];
            tries++;
            for (int n = 0; n < 3; n++) next[n] = at[n] + share * step[n];
            int reaches = next[2] > 0.02 && vxsi_falcon_inverse(next, trial, rows);
            for (int n = 0; n < 3; n++) left[n] = reaches ? angle[n] - trial[n] : 0;
            if (reaches && (most_of(left) < worst || worst < 1e-11)) {
                memcpy(at, next, sizeof at);
                memcpy(miss, left, sizeof miss);
                memcpy(jacobian, rows, sizeof rows);
                break;
            }
            if (halved == MOST_HALVINGS || tries == MOST_TRIES) return 0;
        }
    }
    return 0;
}

int vxsi_falcon_forward(const double angle[3], double place[3])
{
    double at[3];
    memcpy(at, place, sizeof at);
    int is_found = isfinite(fabs(at[0]) + fabs(at[1]) + fabs(at[2])) && newton(angle, at);
    if (!is_found) {
        memcpy(at, middle, sizeof at);
        is_found = newton(angle, at);
    }
    if (is_found) memcpy(place, at, sizeof at);
    return is_found;
}

int vxsi_falcon_torque(const double jacobian[9], const double force[3], double torque[3])
{
    return solve(jacobian, 1, force, torque);
}
