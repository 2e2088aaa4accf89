# SPDX-License-Identifier: MIT
# Haptic assets as targets of a CMake project:
#
#   list(APPEND CMAKE_MODULE_PATH /path/to/voxshell/tools/cmake)
#   include(VoxshellAssets)
#   voxshell_assets(gripper INPUTS jaw.stl robot.gltf OUTPUT ${CMAKE_BINARY_DIR}/assets VOXEL 0.5mm
#                   OPTIONS --unit mm --per-part)
#
# The target `gripper` runs `voxshell batch` whenever an input, a file that one refers to (a .gltf's buffers), or a file in
# a folder among the inputs is newer than OUTPUT/manifest.json; of the parts only those that changed are converted.
# VOXSHELL_EXECUTABLE names the program, else the one in the PATH is taken.
include_guard()
find_program(VOXSHELL_EXECUTABLE voxshell REQUIRED DOC "the command voxshell")

function(voxshell_assets target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "OUTPUT;VOXEL" "INPUTS;OPTIONS;DEPENDS")
  foreach(needed INPUTS OUTPUT VOXEL)
    if(NOT arg_${needed})
      message(FATAL_ERROR "voxshell_assets(${target}): ${needed} is missing")
    endif()
  endforeach()
  set(inputs "")
  foreach(input IN LISTS arg_INPUTS)
    get_filename_component(input "${input}" ABSOLUTE)
    list(APPEND inputs "${input}")
  endforeach()
  get_filename_component(output "${arg_OUTPUT}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_BINARY_DIR}")
  set(manifest "${output}/manifest.json")
  set(depfile "${CMAKE_CURRENT_BINARY_DIR}/${target}.d")
  cmake_policy(SET CMP0116 NEW)
  add_custom_command(OUTPUT "${manifest}"
    COMMAND "${VOXSHELL_EXECUTABLE}" batch ${inputs} -o "${output}" --voxel ${arg_VOXEL} --depfile "${depfile}" ${arg_OPTIONS}
    DEPENDS ${inputs} ${arg_DEPENDS}
    DEPFILE "${depfile}"
    COMMENT "Haptic assets of ${target}" VERBATIM)
  add_custom_target(${target} ALL DEPENDS "${manifest}")
endfunction()
