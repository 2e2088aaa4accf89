/* SPDX-License-Identifier: MIT
 *
 * check.h - tests in C: a failed check prints file, line and fact, and exits with 1.
 *
 *     int main(void)
 *     {
 *         CHECK(2 + 2 == 4);
 *         CHECK_INT(count, 3);            prints both values
 *         CHECK_NEAR(force, 1.5, 1e-12);  absolute tolerance; a NaN fails
 *         CHECK_TEXT(name, "VXS_OK");
 *         return 0;
 *     }
 *
 * SKIP("no device") ends the test with 77: shown as skipped, never as passed. check_length(full, brief) is
 * how long a walk is: brief where VXS_TEST_BRIEF is set, as under an emulator, which takes fifty times as
 * long.
 */
#ifndef VXS_TEST_CHECK_H
#define VXS_TEST_CHECK_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline long check_length(long full, long brief)
{
    return getenv("VXS_TEST_BRIEF") ? brief : full;
}

#define CHECK_FAIL(...)                                                                                      \
    do {                                                                                                     \
        fprintf(stderr, "%s:%d: ", __FILE__, __LINE__);                                                      \
        fprintf(stderr, __VA_ARGS__);                                                                        \
        fputc('\n', stderr);                                                                                 \
        exit(1);                                                                                             \
    } while (0)

#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) CHECK_FAIL("failed: %s", #condition);                                              \
    } while (0)

#define CHECK_INT(actual, expected)                                                                          \
    do {                                                                                                     \
        long long check_a_ = (long long)(actual), check_e_ = (long long)(expected);                          \
        if (check_a_ != check_e_) CHECK_FAIL("%s is %lld, expected %lld", #actual, check_a_, check_e_);      \
    } while (0)

#define CHECK_NEAR(actual, expected, tolerance)                                                              \
    do {                                                                                                     \
        double check_a_ = (actual), check_e_ = (expected);                                                   \
        if (!(fabs(check_a_ - check_e_) <= (tolerance)))                                                     \
            CHECK_FAIL("%s is %.17g, expected %.17g", #actual, check_a_, check_e_);                          \
    } while (0)

#define CHECK_TEXT(actual, expected)                                                                         \
    do {                                                                                                     \
        const char *check_a_ = (actual), *check_e_ = (expected);                                             \
        if (strcmp(check_a_, check_e_) != 0)                                                                 \
            CHECK_FAIL("%s is \"%s\", expected \"%s\"", #actual, check_a_, check_e_);                        \
    } while (0)

#define SKIP(reason)                                                                                         \
    do {                                                                                                     \
        fprintf(stderr, "skipped: %s\n", reason);                                                            \
        exit(77);                                                                                            \
    } while (0)

#endif
