// SPDX-License-Identifier: LGPL-3.0-or-later
// All that differs between DOLFINx 0.5 and 0.9, in one place.
#pragma once

#include <basix/finite-element.h>
#include <basix/quadrature.h>
#include <dolfinx/common/version.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/sparsitybuild.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/la/SparsityPattern.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/generation.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "fem/mesh.hpp"

namespace grus::fem::compat {

#if DOLFINX_VERSION_MINOR >= 9
using Mesh = dolfinx::mesh::Mesh<double>;
using Space = dolfinx::fem::FunctionSpace<double>;
using Element = basix::FiniteElement<double>;
#else
using Mesh = dolfinx::mesh::Mesh;
using Space = dolfinx::fem::FunctionSpace;
using Element = basix::FiniteElement;
#endif

inline dolfinx::mesh::CellType mesh_cell(CellKind k) {
  using dolfinx::mesh::CellType;
  constexpr std::array cells{CellType::triangle, CellType::quadrilateral, CellType::tetrahedron, CellType::hexahedron};
  return cells[static_cast<std::size_t>(k)];
}

inline basix::cell::type basix_cell(CellKind k) {
  using basix::cell::type;
  constexpr std::array cells{type::triangle, type::quadrilateral, type::tetrahedron, type::hexahedron};
  return cells[static_cast<std::size_t>(k)];
}

/// Cuts a mesh as told: its element k goes to rank owner[k]. As DOLFINx does where nothing is told.
inline dolfinx::mesh::CellPartitionFunction cut_by(const std::vector<std::int32_t>& owner) {
  using namespace dolfinx;
  // `neighbours`: of this rank's elements, all by their numbers in the mesh. With ghosts each element goes to the ranks
  // of its neighbours, too: create_mesh finds shared nodes by them even where it leaves them out.
  const auto parts = [&owner](MPI_Comm comm, int, const graph::AdjacencyList<std::int64_t>& neighbours, bool ghosts) {
    const std::int64_t count = neighbours.num_nodes();
    std::int64_t first = 0;
    MPI_Exscan(&count, &first, 1, MPI_INT64_T, MPI_SUM, comm);
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    if (rank == 0) first = 0;  // which MPI_Exscan leaves undefined
    std::vector<std::vector<std::int32_t>> ranks;
    for (std::int32_t k = 0; k < neighbours.num_nodes(); ++k) {
      auto& of = ranks.emplace_back(1, owner[static_cast<std::size_t>(first + k)]);
      for (const std::int64_t next : neighbours.links(k))
        if (const std::int32_t other = owner[static_cast<std::size_t>(next)];
            ghosts && std::find(of.begin(), of.end(), other) == of.end())
          of.push_back(other);
    }
    return graph::AdjacencyList<std::int32_t>(ranks);
  };
#if DOLFINX_VERSION_MINOR >= 9
  if (owner.empty()) return mesh::create_cell_partitioner(mesh::GhostMode::none);
  return mesh::create_cell_partitioner(mesh::GhostMode::none, parts);
#else
  return owner.empty() ? mesh::create_cell_partitioner() : mesh::create_cell_partitioner(parts);
#endif
}

inline std::shared_ptr<Mesh> make_box(MPI_Comm comm, const std::array<double, 3>& size,
                                      const std::array<long, 3>& cells, CellKind kind,
                                      const std::vector<std::int32_t>& owner) {
  using namespace dolfinx::mesh;
  const CellType type = mesh_cell(kind);
  const bool flat = dimension(kind) == 2;
#if DOLFINX_VERSION_MINOR >= 9
  if (flat)
    return std::make_shared<Mesh>(
        create_rectangle<double>(comm, {{{0, 0}, {size[0], size[1]}}}, {cells[0], cells[1]}, type, cut_by(owner)));
  return std::make_shared<Mesh>(
      create_box<double>(comm, {{{0, 0, 0}, size}}, {cells[0], cells[1], cells[2]}, type, cut_by(owner)));
#else
  const std::array<std::size_t, 3> n{static_cast<std::size_t>(cells[0]), static_cast<std::size_t>(cells[1]),
                                     static_cast<std::size_t>(cells[2])};
  if (flat)
    return std::make_shared<Mesh>(
        create_rectangle(comm, {{{0, 0}, {size[0], size[1]}}}, {n[0], n[1]}, type, GhostMode::none, cut_by(owner)));
  return std::make_shared<Mesh>(create_box(comm, {{{0, 0, 0}, size}}, n, type, GhostMode::none, cut_by(owner)));
#endif
}

/// From arrays on rank 0: coordinates (dimension a node) and corners of the elements in basix order.
inline std::shared_ptr<Mesh> make_mesh(MPI_Comm comm, const std::vector<double>& x, std::vector<std::int64_t> cells,
                                       CellKind kind, const std::vector<std::int32_t>& owner) {
  using namespace dolfinx;
  const auto width = static_cast<std::size_t>(dimension(kind));
#if DOLFINX_VERSION_MINOR >= 9
  const dolfinx::fem::CoordinateElement<double> element(mesh_cell(kind), 1);
  return std::make_shared<Mesh>(mesh::create_mesh(comm, comm, std::span<const std::int64_t>(cells), element, comm, x,
                                                  {x.size() / width, width}, cut_by(owner)));
#else
  const dolfinx::fem::CoordinateElement element(mesh_cell(kind), 1);
  const auto per_cell = static_cast<std::size_t>(corners(kind));
  std::vector<std::int32_t> offsets(cells.size() / per_cell + 1);
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = static_cast<std::int32_t>(i * per_cell);
  return std::make_shared<Mesh>(
      mesh::create_mesh(comm, graph::AdjacencyList<std::int64_t>(std::move(cells), std::move(offsets)), element, x,
                        {x.size() / width, width}, mesh::GhostMode::none, cut_by(owner)));
#endif
}

inline const dolfinx::mesh::Topology& topology(const Mesh& mesh) {
#if DOLFINX_VERSION_MINOR >= 9
  return *mesh.topology();
#else
  return mesh.topology();
#endif
}

inline std::int64_t original_cell(const Mesh& mesh, std::int32_t cell) {
#if DOLFINX_VERSION_MINOR >= 9
  return mesh.topology()->original_cell_index[0][static_cast<std::size_t>(cell)];
#else
  return mesh.topology().original_cell_index[static_cast<std::size_t>(cell)];
#endif
}

inline std::span<const std::int32_t> geometry_dofs(const Mesh& mesh, std::int32_t cell) {
#if DOLFINX_VERSION_MINOR >= 9
  const auto map = mesh.geometry().dofmap();
  return {map.data_handle() + static_cast<std::size_t>(cell) * map.extent(1), map.extent(1)};
#else
  return mesh.geometry().dofmap().links(cell);
#endif
}

inline const dolfinx::fem::CoordinateElement
#if DOLFINX_VERSION_MINOR >= 9
    <double>
#endif
        & coordinate_element(const Mesh& mesh) {
  return mesh.geometry().cmap();
}

inline Element make_element(CellKind kind, int degree) {
  const auto cell = basix_cell(kind);
#if DOLFINX_VERSION_MINOR >= 9
  return basix::create_element<double>(basix::element::family::P, cell, degree,
                                       basix::element::lagrange_variant::gll_warped, basix::element::dpc_variant::unset,
                                       false);
#else
  return basix::create_element(basix::element::family::P, cell, degree, basix::element::lagrange_variant::gll_warped,
                               false);
#endif
}

inline std::shared_ptr<Space> make_space(const std::shared_ptr<Mesh>& mesh, const Element& element, int components) {
#if DOLFINX_VERSION_MINOR >= 9
  return std::make_shared<Space>(dolfinx::fem::create_functionspace<double>(
      mesh, element, std::vector<std::size_t>{static_cast<std::size_t>(components)}));
#else
  return std::make_shared<Space>(dolfinx::fem::create_functionspace(mesh, element, components));
#endif
}

/// Points (n x dim, flat) and weights on the reference element or facet.
inline std::array<std::vector<double>, 2> quadrature(basix::cell::type cell, int degree) {
#if DOLFINX_VERSION_MINOR >= 9
  return basix::quadrature::make_quadrature<double>(basix::quadrature::type::Default, cell,
                                                    basix::polyset::type::standard, degree);
#else
  return basix::quadrature::make_quadrature(cell, degree);
#endif
}

/// Values and first derivatives at points of `width` coordinates, flat (1 + width, points, dofs).
inline std::vector<double> tabulate(const Element& element, const std::vector<double>& points, std::size_t width) {
  return element.tabulate(1, std::span<const double>(points), {points.size() / width, width}).first;
}

inline std::vector<double> tabulate_geometry(const Mesh& mesh, const std::vector<double>& points, std::size_t width) {
  const auto& element = coordinate_element(mesh);
  const auto shape = element.tabulate_shape(1, points.size() / width);
  std::vector<double> out(shape[0] * shape[1] * shape[2] * shape[3]);
  element.tabulate(1, points, {points.size() / width, width}, out);
  return out;
}

inline Mat make_matrix(MPI_Comm comm, const Space& space) {
  const auto& map = *space.dofmap();
  const std::array maps{map.index_map, map.index_map};
  const std::array<int, 2> blocks{map.index_map_bs(), map.index_map_bs()};
  dolfinx::la::SparsityPattern pattern(comm, maps, blocks);
#if DOLFINX_VERSION_MINOR >= 9
  const auto cells = space.mesh()->topology()->index_map(space.mesh()->topology()->dim());
  std::vector<std::int32_t> owned(static_cast<std::size_t>(cells->size_local()));
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<std::int32_t>(i);
  dolfinx::fem::sparsitybuild::cells(pattern, {owned, owned}, {map, map});
  pattern.finalize();
#else
  dolfinx::fem::sparsitybuild::cells(pattern, space.mesh()->topology(), {map, map});
  pattern.assemble();
#endif
  return dolfinx::la::petsc::create_matrix(comm, pattern);
}

}  // namespace grus::fem::compat
