# cmake --install: program, manual page, library, headers, CMake package,
# pkg-config file. Everything is found relative to where it lies, so that
# `cmake --install build --prefix X` may put it anywhere.
include(CMakePackageConfigHelpers)

# Public headers: what the program, a client of the library, includes, some that
# only others need, and what these include.
set(public_headers scene/gltf/gltf.h)
function(add_public_headers file)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(STRINGS ${file} includes REGEX "^#include \"[^\"]+\"")
  foreach(line ${includes})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" header "${line}")
    if(NOT header MATCHES "^cli/" AND NOT header IN_LIST public_headers)
      list(APPEND public_headers ${header})
      add_public_headers(${PROJECT_SOURCE_DIR}/src/${header})
    endif()
  endforeach()
  set(public_headers ${public_headers} PARENT_SCOPE)
endfunction()
file(GLOB_RECURSE client_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/cli/*.[ch])
foreach(file ${client_files} ${PROJECT_SOURCE_DIR}/src/scene/gltf/gltf.h)
  add_public_headers(${file})
endforeach()
foreach(header ${public_headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/src/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/reframe/${folder})
endforeach()

# From the tables that --help is made of, so that the two cannot disagree.
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/reframe.1
  COMMAND reframe --man > ${PROJECT_BINARY_DIR}/reframe.1
  DEPENDS reframe COMMENT "Making the manual page" VERBATIM)
add_custom_target(reframe_manual ALL DEPENDS ${PROJECT_BINARY_DIR}/reframe.1)
install(FILES ${PROJECT_BINARY_DIR}/reframe.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)

file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set_target_properties(reframe PROPERTIES INSTALL_RPATH "$ORIGIN/${lib_from_bin}")
install(TARGETS reframe RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# A program of the program: `reframe convert` looks for it relative to itself.
file(RELATIVE_PATH lib_from_import ${CMAKE_INSTALL_FULL_LIBEXECDIR}/reframe ${CMAKE_INSTALL_FULL_LIBDIR})
set_target_properties(reframe_import PROPERTIES INSTALL_RPATH "$ORIGIN/${lib_from_import}")
install(TARGETS reframe_import RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/reframe)
install(TARGETS libreframe EXPORT reframeTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})

# find_package(reframe) gives reframe::reframe.
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/reframe)
install(EXPORT reframeTargets NAMESPACE reframe:: DESTINATION ${package_folder})
configure_package_config_file(${PROJECT_SOURCE_DIR}/scripts/cmake/reframeConfig.cmake.in ${PROJECT_BINARY_DIR}/reframeConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/reframeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/reframeConfig.cmake ${PROJECT_BINARY_DIR}/reframeConfigVersion.cmake
  DESTINATION ${package_folder})

# pkg-config reframe: the libraries that ours needs, which with a static one
# are the user's to link. jansson is in a public header.
set(pc_requires "libpng libjpeg")
set(pc_libs "-lembree${embree_VERSION_MAJOR} -lOpenEXRCore")
foreach(name ${OpenMP_C_LIB_NAMES})
  get_filename_component(openmp_folder "${OpenMP_${name}_LIBRARY}" DIRECTORY)
  if(NOT openmp_folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES) # as with clang
    string(APPEND pc_libs " -L${openmp_folder}")
  endif()
  string(APPEND pc_libs " -l${name}")
endforeach()
string(APPEND pc_libs " ${CMAKE_THREAD_LIBS_INIT} -lm")
if(BUILD_SHARED_LIBS)
  set(pc_needs "Requires: jansson\nRequires.private: ${pc_requires}\nLibs: -L\${libdir} -lreframe\nLibs.private: ${pc_libs}")
else()
  set(pc_needs "Requires: jansson ${pc_requires}\nLibs: -L\${libdir} -lreframe ${pc_libs}")
endif()
set(pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_PREFIX}/${pc_folder} ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix ${pc_prefix})
configure_file(scripts/cmake/reframe.pc.in ${PROJECT_BINARY_DIR}/reframe.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/reframe.pc DESTINATION ${pc_folder})
