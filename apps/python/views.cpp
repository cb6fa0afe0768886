// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/python/views.hpp"

#include "dem/rve/measure.hpp"

namespace grus::python {

namespace py = pybind11;
using Shared = std::shared_ptr<const dem::State>;

namespace {

/// Read-only view of `count` rows of `width` numbers that lie `stride` bytes apart.
template <class T>
py::array view(const Shared& state, const T* first, std::size_t count, std::size_t width, std::size_t stride) {
  const py::capsule owner(new Shared(state), [](void* p) { delete static_cast<Shared*>(p); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count)}, strides{static_cast<py::ssize_t>(stride)};
  if (width > 1) shape.push_back(static_cast<py::ssize_t>(width)), strides.push_back(sizeof(T));
  py::array made(py::dtype::of<T>(), shape, strides, first, owner);
  made.attr("setflags")(py::arg("write") = false);
  return made;
}

template <class Row, class T>
py::array column(const Shared& state, const std::vector<Row>& rows, const T* first, std::size_t width = 1) {
  return view(state, first, rows.size(), width, sizeof(Row));
}

}  // namespace

py::dict grains_of(const Shared& s) {
  const dem::Grains& g = s->grains;
  py::dict d;
  if (g.size() == 0) return d;
  d["id"] = column(s, g.id, g.id.data());
  d["position"] = column(s, g.motion, g.motion[0].position.data(), 3);
  d["velocity"] = column(s, g.motion, g.motion[0].velocity.data(), 3);
  d["spin"] = column(s, g.motion, g.motion[0].spin.data(), 3);
  d["orientation"] = column(s, g.orientation, g.orientation[0].coeffs().data(), 4);
  d["force"] = column(s, g.force, g.force[0].data(), 3);
  d["radius"] = column(s, g.extent, &g.extent[0].equivalent_radius);
  d["volume"] = column(s, g.extent, &g.extent[0].volume);
  d["mass"] = column(s, g.mass, g.mass.data());
  d["material"] = column(s, g.material, g.material.data());
  if (!g.generation.empty()) d["generation"] = column(s, g.generation, g.generation.data());
  if (!g.utilisation.empty()) d["utilisation"] = column(s, g.utilisation, g.utilisation.data());
  return d;
}

py::dict contacts_of(const dem::State& s) {
  std::vector<std::size_t> touching;
  for (std::size_t k = 0; k < s.contacts.begin[dem::first_wall]; ++k)
    if (s.contacts.contact.touching(k)) touching.push_back(k);
  const auto n = static_cast<py::ssize_t>(touching.size());
  py::array_t<std::uint32_t> a(n), b(n);
  py::array_t<double> overlap(n), normal({n, py::ssize_t{3}}), force({n, py::ssize_t{3}}), branch({n, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < n; ++i) {
    const std::size_t k = touching[static_cast<std::size_t>(i)];
    const dem::Touch& touch = s.contacts.touch[k];
    const dem::Vec3 l = dem::branch(s, k);
    a.mutable_at(i) = s.contacts.pair[k].a, b.mutable_at(i) = s.contacts.pair[k].b;
    overlap.mutable_at(i) = touch.overlap;
    for (int c = 0; c < 3; ++c) {
      normal.mutable_at(i, c) = touch.normal[c];
      force.mutable_at(i, c) = touch.force[c];
      branch.mutable_at(i, c) = l[c];
    }
  }
  py::dict d;
  d["a"] = a, d["b"] = b, d["overlap"] = overlap, d["normal"] = normal, d["force"] = force, d["branch"] = branch;
  return d;
}

}  // namespace grus::python
