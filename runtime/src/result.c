/* SPDX-License-Identifier: MIT */
#include "voxshell/result.h"

const char *vxs_result_name(vxs_result result)
{
    switch (result) {
#define NAME(name, value, text)                                                                              \
    case VXS_##name:                                                                                         \
        return "VXS_" #name;
        VXS_RESULT_LIST(NAME)
#undef NAME
    }
    return "VXS_?";
}

const char *vxs_result_text(vxs_result result)
{
    switch (result) {
#define TEXT(name, value, text)                                                                              \
    case VXS_##name:                                                                                         \
        return text;
        VXS_RESULT_LIST(TEXT)
#undef TEXT
    }
    return "not a result of this library";
}
