# SPDX-License-Identifier: LGPL-3.0-or-later
# cpack -G DEB, in the build folder: grus (programs, scenes), libgrus-dev (headers, libraries), python3-grus (its compiled core).
set(CPACK_PACKAGE_NAME grus)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL Unspecified dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)  # the one that each Debian reads
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/debian/maintainer.cmake)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian/policy.cmake)
set(CPACK_GRUS_SOURCE_DIR ${PROJECT_SOURCE_DIR})  # for these two
# Python's modules are compiled where they are installed, and what came of it goes with the package.
foreach(script postinst prerm)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/debian/${script} ${PROJECT_BINARY_DIR}/debian/grus/${script} COPYONLY FILE_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
endforeach()
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/debian/grus/postinst;${PROJECT_BINARY_DIR}/debian/grus/prerm")
set(about "Grus computes how grains break, and what that does to the sand, rock or powder
that they make up: the discrete element method with spheres, poly-ellipsoids
and polyhedra that break, alone or at each point of a finite-element mesh.
")
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME grus)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SECTION science)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_DEPENDS "python3, python3-numpy, python3-matplotlib, python3-scipy, python3-jsonschema")
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_BREAKS "python3-grus (<< ${PROJECT_VERSION})")  # it had the Python modules
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_REPLACES "python3-grus (<< ${PROJECT_VERSION})")
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "python3-h5py, bash-completion")  # pictures of grains and exports; keys on Tab
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SUGGESTS "python3-petsc4py, paraview")
set(CPACK_DEBIAN_UNSPECIFIED_DESCRIPTION "grains that break, alone and in finite elements
${about}
This package holds the programs, their manual pages, the Python module of runs
and results, and scenes to begin with.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libgrus-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_DESCRIPTION "grains that break, alone and in finite elements (C++ library)
${about}
This package holds the headers, the static libraries and their CMake files.")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev, nlohmann-json3-dev, libhdf5-dev")
if(GRUS_FEM)
  set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev, nlohmann-json3-dev, libdolfinx-real-dev, libdolfinx-dev")
endif()
if(GRUS_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-grus)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "grains that break, as a material in Python
${about}
This package holds the compiled core of the module grus: cells of grains as the
material of your own solver, or of preCICE.")
  math(EXPR after "${Python_VERSION_MINOR} + 1")  # the module is built for one Python
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${after}), python3-numpy, grus (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-mpi4py, python3-pandas, python3-dolfinx")
endif()
include(CPack)
