# SPDX-License-Identifier: LGPL-3.0-or-later
# find_package(grus) gives grus::dem, grus::scene and, where built, grus::fem and grus::coupling.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
install(TARGETS grus_dem grus_scene EXPORT grusTargets)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/dem DESTINATION include/grus FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/apps/scene DESTINATION include/grus/apps FILES_MATCHING PATTERN "*.hpp"
  PATTERN "bvp_scene.hpp" EXCLUDE PATTERN "mesh_scene.hpp" EXCLUDE PATTERN "packing_scene.hpp" EXCLUDE
  PATTERN "reader.hpp" EXCLUDE PATTERN "units.hpp" EXCLUDE)
if(GRUS_FEM)
  install(TARGETS grus_fem grus_coupling EXPORT grusTargets)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/fem ${PROJECT_SOURCE_DIR}/coupling DESTINATION include/grus FILES_MATCHING PATTERN "*.hpp"
    PATTERN "*_impl.hpp" EXCLUDE PATTERN "acceleration.hpp" EXCLUDE PATTERN "dolfinx_compat.hpp" EXCLUDE)
endif()
install(EXPORT grusTargets NAMESPACE grus:: DESTINATION lib/cmake/grus)
if(HDF5_IS_PARALLEL)
  set(GRUS_HDF5_PARALLEL ON)  # its header wants mpi.h
else()
  set(GRUS_HDF5_PARALLEL OFF)
endif()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/grusConfig.cmake.in ${PROJECT_BINARY_DIR}/grusConfig.cmake INSTALL_DESTINATION lib/cmake/grus)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/grusConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/grusConfig.cmake ${PROJECT_BINARY_DIR}/grusConfigVersion.cmake DESTINATION lib/cmake/grus)
