# SPDX-License-Identifier: Apache-2.0

# The public libraries: shared, with their public functions alone visible, and installed with headers, CMake package and
# pkg-config files. A consumer gets no option of ours but C++20.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# What our code is compiled with, but for the processor's own instructions.
add_library(tactel_portable_options INTERFACE)
target_compile_options(tactel_portable_options INTERFACE -Wall -Wextra $<$<BOOL:${TACTEL_WERROR}>:-Werror>)
target_include_directories(tactel_portable_options INTERFACE ${PROJECT_SOURCE_DIR})
if(TACTEL_SANITIZE)
  target_compile_options(tactel_portable_options INTERFACE -fsanitize=${TACTEL_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(tactel_portable_options INTERFACE -fsanitize=${TACTEL_SANITIZE})
  target_compile_definitions(tactel_portable_options INTERFACE TACTEL_SANITIZED)
endif()

# tactel_part_of_libraries(targets...): static libraries that become parts of a shared one, which hides them.
function(tactel_part_of_libraries)
  set_target_properties(${ARGN} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# tactel_library(COMPONENT sources...): the library tactel_COMPONENT, as target tactel::COMPONENT, with the headers of the folder
# include/ beside it.
function(tactel_library component)
  add_library(tactel_${component} ${ARGN})  # BUILD_SHARED_LIBS: shared or an archive
  add_library(tactel::${component} ALIAS tactel_${component})
  target_link_libraries(tactel_${component} PRIVATE $<BUILD_INTERFACE:tactel_portable_options>)
  target_compile_features(tactel_${component} PUBLIC cxx_std_20)
  target_compile_definitions(tactel_${component} PRIVATE TACTEL_VERSION="${TACTEL_VERSION}")
  target_include_directories(tactel_${component} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>)
  set_target_properties(tactel_${component} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR} EXPORT_NAME ${component}
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON INSTALL_RPATH "$ORIGIN"
    LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/public_symbols.map)
  target_link_options(tactel_${component} PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/public_symbols.map)
  if(NOT TACTEL_SANITIZE)  # whose functions the program brings
    target_link_options(tactel_${component} PRIVATE -Wl,--no-undefined)
  endif()
endfunction()

# tactel_install_libraries(components...)
function(tactel_install_libraries)
  if(NOT TACTEL_INSTALL)
    return()
  endif()
  set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tactel)
  # What a C program links beside an archive.
  set(standard ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
  list(REMOVE_ITEM standard ${CMAKE_C_IMPLICIT_LINK_LIBRARIES})
  list(TRANSFORM standard PREPEND -l)
  list(JOIN standard " " TACTEL_PC_PRIVATE)
  file(RELATIVE_PATH TACTEL_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)  # the tree may be moved
  foreach(component ${ARGN})
    get_target_property(folder tactel_${component} SOURCE_DIR)
    set(headers ${folder}/include/)
    if(component STREQUAL "simulate")
      list(APPEND headers ${PROJECT_SOURCE_DIR}/fem/include/)
    endif()
    install(DIRECTORY ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
    install(TARGETS tactel_${component} EXPORT tactel-${component}
            LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries NAMELINK_COMPONENT development
            ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
            INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    install(EXPORT tactel-${component} FILE tactel-${component}.cmake NAMESPACE tactel:: DESTINATION ${package} COMPONENT development)
    set(pc tactel.pc)
    if(NOT component STREQUAL "infer")
      set(pc tactel-${component}.pc)
    endif()
    configure_file(${PROJECT_SOURCE_DIR}/cmake/${pc}.in ${PROJECT_BINARY_DIR}/${pc} @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/${pc} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
  endforeach()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/tactel-config.cmake.in ${PROJECT_BINARY_DIR}/tactel-config.cmake @ONLY)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/tactel-config-version.cmake COMPATIBILITY SameMajorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/tactel-config.cmake ${PROJECT_BINARY_DIR}/tactel-config-version.cmake
          DESTINATION ${package} COMPONENT development)
endfunction()
