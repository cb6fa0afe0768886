# SPDX-License-Identifier: LGPL-3.0-or-later
# find_package(grus) gives grus::grus (the DEM and its scenes) and, where built, grus::fem and grus::coupling.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
# What grus/rve.hpp, grus/sample.hpp and grus/scene.hpp need, and no more; tools/check_install.py compiles each alone.
set(public_dem
  base/error.hpp base/habit.hpp base/parallel.hpp base/random.hpp base/tensor.hpp base/watch.hpp contact/broad_phase.hpp
  contact/deepest_contact.hpp
  contact/foundation.hpp contact/hertz_mindlin.hpp contact/jkr.hpp contact/law.hpp contact/laws.hpp contact/linear_spring.hpp contact/neighbours.hpp fracture/cleavage.hpp fracture/criteria.hpp fracture/fracture_model.hpp fracture/splitter.hpp
  kernel/contact_pass.hpp kernel/hull_overlap.hpp kernel/sweep.hpp motion/integrate.hpp packing/cells.hpp packing/packing.hpp packing/voronoi.hpp
  rve/loading.hpp rve/measure.hpp rve/model.hpp rve/rve.hpp rve/state.hpp rve/step.hpp
  rve/stepper.hpp rves/driver_options.hpp rves/host.hpp rves/rve_set.hpp sample/gauge.hpp
  sample/make.hpp sample/network.hpp sample/prepare.hpp sample/programme.hpp sample/recipe.hpp shape/hull_store.hpp shape/polyellipsoid.hpp
  shape/polyhedron.hpp state/bonds.hpp state/boundary.hpp state/contacts.hpp state/grains.hpp state/ledger.hpp)
function(grus_headers room)
  foreach(header IN LISTS ARGN)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${PROJECT_SOURCE_DIR}/${room}/${header} DESTINATION include/grus/${room}/${folder} COMPONENT dev)
  endforeach()
endfunction()
grus_headers(dem ${public_dem})
grus_headers(apps scene/prepare_sample.hpp scene/rve_scene.hpp scene/unit_cells.hpp)
install(FILES ${PROJECT_SOURCE_DIR}/apps/library/grus/rve.hpp ${PROJECT_SOURCE_DIR}/apps/library/grus/sample.hpp
  ${PROJECT_SOURCE_DIR}/apps/library/grus/scene.hpp DESTINATION include/grus COMPONENT dev)
install(TARGETS grus_dem grus_scene grus_library EXPORT grusTargets ARCHIVE COMPONENT dev)
if(GRUS_FEM)
  grus_headers(fem dynamics.hpp explicit_statics.hpp macro_energy.hpp material.hpp mesh.hpp problem.hpp session.hpp statics.hpp)
  grus_headers(coupling rank_loads.hpp rve_farm.hpp rve_material.hpp)
  grus_headers(dem rve/linear_response.hpp rves/deferral.hpp rves/driver.hpp rves/driver_book.hpp rves/rve_host.hpp rves/sharing.hpp rves/tangents.hpp)
  install(TARGETS grus_fem grus_coupling EXPORT grusTargets ARCHIVE COMPONENT dev)
endif()
install(EXPORT grusTargets NAMESPACE grus:: DESTINATION lib/cmake/grus COMPONENT dev)
if(HDF5_IS_PARALLEL)
  set(GRUS_HDF5_PARALLEL ON)  # its header wants mpi.h
else()
  set(GRUS_HDF5_PARALLEL OFF)
endif()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/grusConfig.cmake.in ${PROJECT_BINARY_DIR}/grusConfig.cmake INSTALL_DESTINATION lib/cmake/grus)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/grusConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/grusConfig.cmake ${PROJECT_BINARY_DIR}/grusConfigVersion.cmake DESTINATION lib/cmake/grus COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/apps/scenes DESTINATION share/grus)
if(GRUS_PYTHON)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/apps/python/demos DESTINATION share/grus/python COMPONENT python)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/grus)
