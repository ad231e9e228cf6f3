# cmake --install: program, manual page, completion, library, headers, CMake package,
# pkg-config file. Everything is found relative to where it lies, so that
# `cmake --install build --prefix X` may put it anywhere.
include(CMakePackageConfigHelpers)

# Two parts: the program, and `development`, what a program that uses the library
# is built with. Public headers are those of src/reframe, and no others.
file(GLOB public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/reframe/*.h)
install(FILES ${public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/reframe COMPONENT development)

# From the tables that --help is made of, so that the two cannot disagree.
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/reframe.1
  COMMAND reframe --man > ${PROJECT_BINARY_DIR}/reframe.1
  DEPENDS reframe COMMENT "Making the manual page" VERBATIM)
add_custom_target(reframe_manual ALL DEPENDS ${PROJECT_BINARY_DIR}/reframe.1)
install(FILES ${PROJECT_BINARY_DIR}/reframe.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)

install(TARGETS reframe RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# From the same tables.
foreach(shell bash zsh)
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/reframe.${shell}
    COMMAND reframe completion ${shell} > ${PROJECT_BINARY_DIR}/reframe.${shell}
    DEPENDS reframe COMMENT "Making the completion for ${shell}" VERBATIM)
endforeach()
add_custom_target(reframe_completion ALL DEPENDS ${PROJECT_BINARY_DIR}/reframe.bash ${PROJECT_BINARY_DIR}/reframe.zsh)
install(FILES ${PROJECT_BINARY_DIR}/reframe.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME reframe)
install(FILES ${PROJECT_BINARY_DIR}/reframe.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _reframe)

# The add-on of Blender, where there is a Python to pack it.
find_program(REFRAME_PYTHON python3)
set(addon)
if(REFRAME_PYTHON)
  set(addon ${PROJECT_BINARY_DIR}/reframe-blender.zip)
  file(GLOB addon_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/scripts/blender/*)
  list(FILTER addon_files EXCLUDE REGEX "__pycache__")
  add_custom_command(OUTPUT ${addon} COMMAND ${REFRAME_PYTHON} -B ${PROJECT_SOURCE_DIR}/scripts/blender/pack --output ${addon}
    DEPENDS ${addon_files} ${PROJECT_SOURCE_DIR}/CMakeLists.txt COMMENT "Packing the add-on of Blender" VERBATIM)
  install(FILES ${addon} DESTINATION ${CMAKE_INSTALL_DATADIR}/reframe)
endif()
add_custom_target(reframe_addon ALL DEPENDS ${addon})

# All that is installed and nothing else, for a build without the tests.
add_custom_target(reframe_installed DEPENDS reframe reframe_import libreframe reframe_manual reframe_completion reframe_addon)

# A program of the program: `reframe convert` looks for it relative to itself.
install(TARGETS reframe_import RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/reframe)
install(TARGETS libreframe EXPORT reframeTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)

# find_package(reframe) gives reframe::reframe.
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/reframe)
install(EXPORT reframeTargets NAMESPACE reframe:: DESTINATION ${package_folder} COMPONENT development)
configure_package_config_file(${PROJECT_SOURCE_DIR}/scripts/cmake/reframeConfig.cmake.in ${PROJECT_BINARY_DIR}/reframeConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/reframeConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/reframeConfig.cmake ${PROJECT_BINARY_DIR}/reframeConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT development)

# pkg-config reframe: the libraries that ours needs, which with a static one
# are the user's to link.
set(pc_requires "libpng libjpeg jansson fftw3f")
if("WebP" IN_LIST REFRAME_WITH)
  string(APPEND pc_requires " libwebp")
endif()
set(pc_libs "-lembree${embree_VERSION_MAJOR} -lOpenEXRCore")
foreach(name ${OpenMP_C_LIB_NAMES})
  get_filename_component(openmp_folder "${OpenMP_${name}_LIBRARY}" DIRECTORY)
  if(NOT openmp_folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES) # as with clang
    string(APPEND pc_libs " -L${openmp_folder}")
  endif()
  string(APPEND pc_libs " -l${name}")
endforeach()
if("Draco" IN_LIST REFRAME_WITH)
  string(APPEND pc_libs " -ldraco -lstdc++")
endif()
if("DWA" IN_LIST REFRAME_WITH)
  string(APPEND pc_libs " -lOpenEXR -lstdc++")
endif()
if("meshoptimizer" IN_LIST REFRAME_WITH)
  string(APPEND pc_libs " -lmeshoptimizer")
endif()
string(APPEND pc_libs " ${CMAKE_THREAD_LIBS_INIT} -lm")
if(BUILD_SHARED_LIBS)
  set(pc_needs "Requires.private: ${pc_requires}\nLibs: -L\${libdir} -lreframe\nLibs.private: ${pc_libs}")
else()
  set(pc_needs "Requires: ${pc_requires}\nLibs: -L\${libdir} -lreframe ${pc_libs}")
endif()
set(pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_PREFIX}/${pc_folder} ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix ${pc_prefix})
configure_file(scripts/cmake/reframe.pc.in ${PROJECT_BINARY_DIR}/reframe.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/reframe.pc DESTINATION ${pc_folder} COMPONENT development)

# cpack: two .deb, `reframe` with the program and `libreframe-dev` with the library. zsh of Debian looks in a folder of its own.
file(WRITE ${PROJECT_BINARY_DIR}/move_zsh.cmake [=[
set(zsh ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/Unspecified/usr/share/zsh)
if(EXISTS ${zsh}/site-functions)
  file(RENAME ${zsh}/site-functions ${zsh}/vendor-completions)
endif()
]=])
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_BINARY_DIR}/move_zsh.cmake)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGE_CONTACT "${REFRAME_CONTACT}")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME reframe)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SECTION graphics)
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION "renders camera animations, with paths reused in neighbouring frames")
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libreframe-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "the library of reframe, which renders camera animations")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ${BUILD_SHARED_LIBS})
if(NOT BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libembree-dev, libopenexr-dev, libjansson-dev, libfftw3-dev, libpng-dev, libjpeg-dev, pkg-config | pkgconf")
  if("WebP" IN_LIST REFRAME_WITH)
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libwebp-dev")
  endif()
  if("Draco" IN_LIST REFRAME_WITH)
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libdraco-dev")
  endif()
  if("meshoptimizer" IN_LIST REFRAME_WITH)
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libmeshoptimizer-dev")
  endif()
endif()
include(CPack)
