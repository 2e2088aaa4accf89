# Debian packages: `cpack` in a build folder. One component a package; what each holds is said where it is installed.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME voxshell)
set(CPACK_PACKAGE_CONTACT "voxshell developers <dev@voxshell.invalid>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/runtime)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_COMPONENTS_ALL library devices dev)
if(VOXSHELL_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL tools doc)
endif()

# vxs_package(COMPONENT NAME SECTION LICENCE "summary" "text" [COMPONENT...]): the components that it needs come last.
# LICENCE is the file of the room that the package is made of.
macro(vxs_package component name section licence summary text)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DISPLAY_NAME "${summary}")
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${text}")
  set(CPACK_COMPONENT_${upper}_DEPENDS ${ARGN})
  set(copyright ${CMAKE_BINARY_DIR}/copyright/${component}/copyright)
  file(READ ${PROJECT_SOURCE_DIR}/LICENSE rooms)
  file(READ ${PROJECT_SOURCE_DIR}/${licence} room)
  file(CONFIGURE OUTPUT ${copyright} CONTENT "${rooms}\nThis package: ${licence}\n\n${room}" @ONLY)
  install(FILES ${copyright} ${PROJECT_SOURCE_DIR}/CHANGELOG.md
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endmacro()

vxs_package(library libvoxshell${PROJECT_VERSION_MAJOR} libs runtime/LICENSE "haptic rendering by the Voxmap-PointShell method: runtime"
  "Maps voxmaps and pointshells that voxshell-tools has made and gives force and\ntorque at 1 kHz and more. It needs the C library and nothing else.")
vxs_package(devices libvoxshell-devices${PROJECT_VERSION_MAJOR} libs runtime/LICENSE "haptic devices for voxshell's runtime"
  "Haply, SpaceMouse, microcontrollers that speak hvlink, recordings; udev rules." library)
vxs_package(dev libvoxshell-dev libdevel runtime/LICENSE "haptic rendering by the Voxmap-PointShell method: headers"
  "Headers, archives, and what CMake and pkg-config need to find them." library devices)
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS libusb-1.0-0-dev) # to link the archive of the devices
if(VOXSHELL_TOOLS)
  vxs_package(tools voxshell-tools science tools/LICENSE "CAD scenes to voxmaps and pointshells"
    "Converts glTF and STL, one part or whole assemblies, checks and compares what\ncame out, simulates and measures it, designs the virtual coupling.")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "gnuplot-nox")
  vxs_package(doc voxshell-doc doc formats/LICENSE "voxshell: guide, formats, samples"
    "The guide, the specifications of the file formats and the sample programs.")
  set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
endif()
include(CPack)
