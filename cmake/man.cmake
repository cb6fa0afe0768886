# SPDX-License-Identifier: LGPL-3.0-or-later
# Man pages of the programs, from what they say with --help and --version, where help2man is installed.
find_program(HELP2MAN help2man)
if(NOT HELP2MAN)
  return()
endif()
include(GNUInstallDirs)
set(manuals)
macro(grus_manual program about)
  set(page ${PROJECT_BINARY_DIR}/man/${program}.1)
  add_custom_command(OUTPUT ${page} DEPENDS ${PROJECT_BINARY_DIR}/bin/${program} ${ARGN} VERBATIM
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
    COMMAND ${HELP2MAN} --no-info --no-discard-stderr --name=${about} --output=${page} ${PROJECT_BINARY_DIR}/bin/${program})
  list(APPEND manuals ${page})
endmacro()
file(GLOB_RECURSE grus_modules ${PROJECT_BINARY_DIR}/python/grus/*.py)
grus_manual(grus "grains that break: one command for all programs" ${grus_modules})
grus_manual(grus-rve "tests of samples of grains that break")
grus_manual(grus-report "tables, plots and pictures of results" ${grus_modules})
grus_manual(grus-study "sweeps, and error against run time" ${grus_modules})
grus_manual(grus-calibrate "parameters of grains from measured data" ${grus_modules})
if(GRUS_FEM)
  grus_manual(grus-bvp "boundary-value problems with grains at every Gauss point")
endif()
add_custom_target(man ALL DEPENDS ${manuals})
add_dependencies(programs man)  # installed with them
install(FILES ${manuals} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
