# OpenVDB, found without its FindOpenVDB.cmake: that one demands Boost.Iostreams, which nothing here needs.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
find_package(Imath CONFIG QUIET REQUIRED)
find_path(NANOVDB_INCLUDE_DIR nanovdb/NanoVDB.h REQUIRED)

add_library(voxshell_vdb STATIC vdb.cpp vdb_answer.cpp vdb_cells.cpp vdb_foreign.cpp vdb_parse.cpp vdb_read.cpp nvdb.cpp)
target_include_directories(voxshell_vdb SYSTEM PRIVATE ${OPENVDB_INCLUDE_DIR} ${NANOVDB_INCLUDE_DIR})
target_link_libraries(voxshell_vdb PUBLIC voxshell_tools voxshell_container voxshell_voxmap
  PRIVATE voxshell_fence ${OPENVDB_LIBRARY} Imath::Imath)
# Hidden, our copy of Grid::treeType() shares its once-flag with the library but not the string that the flag
# guards, and openvdb::initialize() reads a null pointer.
set_source_files_properties(vdb.cpp vdb_foreign.cpp vdb_parse.cpp nvdb.cpp PROPERTIES COMPILE_OPTIONS -fvisibility=default)
