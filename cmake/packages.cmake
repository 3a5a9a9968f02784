# SPDX-License-Identifier: Apache-2.0

# The program with its manual, completion, examples and udev rule, and the Debian packages `tactel`, `tactel-mpi` and `tactel-dev`
# (scripts/package).
include(GNUInstallDirs)

install(TARGETS tactel RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/tactel/examples COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT program)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program
        FILES_MATCHING REGEX "[.](md|svg|webp|sh)$")
install(FILES scripts/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME tactel
        COMPONENT program)
install(FILES scripts/70-tactel.rules DESTINATION lib/udev/rules.d COMPONENT program)

if(TACTEL_PACKAGE)
  find_program(HELP2MAN help2man REQUIRED)
  set(manual ${PROJECT_BINARY_DIR}/manual)
  add_custom_command(OUTPUT ${manual}/tactel.1 DEPENDS tactel ${PROJECT_SOURCE_DIR}/cmake/manual.cmake
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:tactel> -DHELP2MAN=${HELP2MAN} -DVERSION=${TACTEL_VERSION} -DFOLDER=${manual}
            -DDOCS=/usr/share/doc/tactel/docs -DEXAMPLES=/usr/share/tactel/examples
            -P ${PROJECT_SOURCE_DIR}/cmake/manual.cmake
    COMMAND ${CMAKE_COMMAND} -E echo ".so man1/tactel.1" > ${manual}/tactel-mpi.so)
  add_custom_target(tactel_manual ALL DEPENDS ${manual}/tactel.1)
  install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program FILES_MATCHING PATTERN "*.1")
  install(FILES ${manual}/tactel-mpi.so DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 RENAME tactel-mpi.1 COMPONENT mpi)
  install(TARGETS tactel-mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mpi)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tactel)
string(REPLACE "-" "~" CPACK_DEBIAN_PACKAGE_VERSION ${TACTEL_VERSION})  # a release sorts after its candidates
set(CPACK_PACKAGE_VENDOR "The tactel maintainers")  # as CITATION.cff
set(CPACK_PACKAGE_CONTACT "The tactel maintainers <maintainers@tactel.example>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "simulates a tactile skin and detects incipient slip")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program libraries development mpi)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENT_PROGRAM_GROUP tactel)
set(CPACK_COMPONENT_LIBRARIES_GROUP tactel)
set(CPACK_COMPONENT_DEVELOPMENT_GROUP dev)
set(CPACK_COMPONENT_MPI_GROUP mpi)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_TACTEL_PACKAGE_NAME tactel)
set(CPACK_DEBIAN_TACTEL_PACKAGE_DEPENDS "pocl-opencl-icd | opencl-icd")
set(CPACK_DEBIAN_TACTEL_PACKAGE_RECOMMENDS librsvg2-bin)  # plots as PNG and PDF
set(CPACK_DEBIAN_MPI_PACKAGE_NAME tactel-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "tactel (= ${CPACK_DEBIAN_PACKAGE_VERSION}), openmpi-bin")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME tactel-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "tactel (= ${CPACK_DEBIAN_PACKAGE_VERSION})")
include(CPack)
