# SPDX-License-Identifier: LGPL-3.0-or-later
# Run by cpack when files lie where they will, before they are packed: what Debian's policy wants in a package and nobody else needs.
if(NOT CPACK_GENERATOR STREQUAL "DEB")
  return()
endif()
find_program(GZIP gzip REQUIRED)
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(Unspecified grus)
set(dev ${CPACK_DEBIAN_DEV_PACKAGE_NAME})
set(python ${CPACK_DEBIAN_PYTHON_PACKAGE_NAME})
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component}${CPACK_PACKAGING_INSTALL_PREFIX})
  set(texts ${root}/share/doc/${${component}})
  file(COPY ${CPACK_GRUS_SOURCE_DIR}/cmake/debian/copyright DESTINATION ${texts}
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  file(REMOVE ${texts}/LICENSE)  # the copyright file says where it lies in Debian
  file(WRITE ${texts}/changelog
    "grus (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n  * See /usr/share/doc/grus/CHANGELOG.md.\n\n -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${now}\n")
  if(EXISTS ${root}/share/zsh/site-functions)  # Debian's zsh looks elsewhere for what packages bring
    file(RENAME ${root}/share/zsh/site-functions ${root}/share/zsh/vendor-completions)
  endif()
  file(GLOB pages ${root}/share/man/man*/*.[0-9])
  execute_process(COMMAND ${GZIP} -9 -n -f ${texts}/changelog ${pages} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
