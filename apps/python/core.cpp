// SPDX-License-Identifier: LGPL-3.0-or-later
// What Python cannot do itself: scenes, unit cells and sets of RVEs. Arguments are checked and explained in
// grus/rves.py.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "apps/python/recipes.hpp"
#include "apps/python/views.hpp"
#include "apps/run/cores.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/unit_cells.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/checkpoint.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rves/rve_set.hpp"

namespace grus::python {
namespace {

namespace py = pybind11;
using Numbers = py::array_t<double, py::array::c_style>;

/// Hears Ctrl-C; asked by the calling thread, which has let go of Python.
bool go_on(double) {
  const py::gil_scoped_acquire held;
  return PyErr_CheckSignals() == 0;
}

/// Long work, without Python's lock. What `go_on` has heard is an error of Python's own.
template <class F>
auto at_work(F&& work) {
  try {
    const py::gil_scoped_release free;
    return work();
  } catch (const dem::Interrupted&) {
    throw py::error_already_set();
  }
}

class UnitCells {
public:
  UnitCells(const std::string& scene, const std::vector<std::string>& overrides, int variants)
      : cells_(app::read_unit_cells(scene, overrides, variants)) {
    make();
  }
  /// Without a scene file; the v-th has seed + v.
  UnitCells(const py::dict& asked, const std::string& name, int variants) {
    for (int v = 0; v < variants; ++v) {
      cells_.push_back(scene_of(asked, name));
      cells_.back().model.seed += static_cast<std::uint64_t>(v);
    }
    make();
  }

  std::string record() const { return cells_[0].record->dump(); }
  std::vector<std::string> notes() const { return cells_[0].notes; }
  std::vector<std::string> materials() const {
    std::vector<std::string> names;
    for (const auto& m : cells_[0].model.materials) names.push_back(m.name);
    return names;
  }

  py::bytes prepare(std::size_t variant) const {
    return at_work([&] {
      dem::Team alone(1);
      const app::RveScene& cell = cells_.at(variant);
      const auto& made = samples_.at(variant);
      const auto watch = [](double d, const char*) { return go_on(d); };
      try {
        app::Base base = app::prepare_base(cell, made ? &*made : nullptr, alone, watch);
        return dem::bytes_of(dem::start_from(std::move(base.state), cell.model, cell.recipe.preparation, alone, watch));
      } catch (const dem::Unstable& e) {
        const std::string why = e.what(), file = cells_[0].file;
        throw dem::Unstable(why.starts_with(file + ":") ? why : file + ": " + why);
      }
    });
  }

  const app::RveScene& first() const { return cells_[0]; }
  std::uint64_t kin() const { return app::kin_of(cells_[0]); }

private:
  void make() {
    for (auto& cell : cells_)
      if (const auto& sample = samples_.emplace_back(app::made_at_once(cell))) app::settle(cell, *sample);
  }

  std::vector<app::RveScene> cells_;
  std::vector<std::optional<dem::Sample>> samples_;  // random packings are made when they are prepared
};

class Set {
public:
  Set(const UnitCells& cells, const std::vector<py::bytes>& prepared, const std::vector<std::size_t>& start,
      const std::string& response, int threads)
      : options_(app::options_of_text(response, "RveSet", cells.first())),
        set_(std::make_shared<dem::Model>(cells.first().model), states(prepared), start, options_, threads,
             cells.kin()) {}

  void advance(const Numbers& deformation, Numbers stress, const std::optional<Numbers>& tangent) {
    const Use use(busy_);
    auto all = [](Numbers& a) { return std::span(a.mutable_data(), static_cast<std::size_t>(a.size())); };
    const std::span<const double> in(deformation.data(), static_cast<std::size_t>(deformation.size()));
    const std::span<double> out = all(stress);
    std::span<double> stiffness;
    if (Numbers a = tangent.value_or(Numbers()); tangent) stiffness = all(a);
    at_work([&] { set_.advance(in, out, stiffness, go_on); });
  }

  void commit() {
    const Use use(busy_);
    set_.commit();
  }

  /// Columns, one row a point.
  py::dict facts() const {
    const Use use(busy_);
    const auto n = static_cast<py::ssize_t>(set_.size());
    py::array_t<double> energy(n), void_ratio(n), work(n), mass(n), lost(n);
    py::array_t<std::uint64_t> grains(n), breakages(n), steps(n);
    for (py::ssize_t i = 0; i < n; ++i) {
      const dem::Facts f = set_.facts(static_cast<std::size_t>(i));
      energy.mutable_at(i) = f.energy_error, void_ratio.mutable_at(i) = f.void_ratio, work.mutable_at(i) = f.work;
      mass.mutable_at(i) = f.mass - f.lost_mass, lost.mutable_at(i) = f.lost_mass, grains.mutable_at(i) = f.grains;
      breakages.mutable_at(i) = f.breakages, steps.mutable_at(i) = f.steps;
    }
    py::dict d;
    d["grains"] = grains, d["breakages"] = breakages, d["steps"] = steps, d["void_ratio"] = void_ratio;
    d["work_J"] = work, d["energy_error"] = energy, d["mass_kg"] = mass, d["mass_lost_kg"] = lost;
    return d;
  }

  /// By the names of grus-bvp's summary.json.
  py::dict report() const {
    const Use use(busy_);
    const dem::SweepReport& r = set_.report();
    py::dict d, errors;
    d["asked"] = r.asked, d["advanced"] = r.advanced, d["deferred"] = r.deferred, d["elastic"] = r.elastic;
    d["similar"] = r.similar, d["replayed"] = r.replayed, d["retried_in_parts"] = r.retried, d["distinct"] = r.distinct;
    d["dem_steps"] = r.dem_steps;
    d["worst_unbalanced_force"] = r.worst_unbalanced, d["worst_stress_change"] = r.worst_stress_change;
    const auto told = [&](const char* device, const char* tolerance, double value, const dem::MeasuredError& by,
                          const char* measured) {
      py::dict e;
      const auto known = [&](double error) { return by.count > 0 ? py::object(py::float_(error)) : py::none(); };
      e[tolerance] = value, e[measured] = by.count, e["worst"] = known(by.worst), e["mean"] = known(by.mean());
      errors[device] = e;
      return e;
    };
    if (options_.error > 0)
      told("deferral", "tolerance", options_.error, r.deferral, "measured")["least_trust"] = r.least_trust;
    if (options_.response.elastic >= 0)
      told("elastic", "tolerance_force_share", options_.response.elastic, r.linear, "measured");
    if (options_.share > 0)
      told("sharing", "tolerance_strain", options_.share, r.sharing, "measured_at_replays")["largest_correction"] =
          r.correction;
    d["errors"] = errors;
    return d;
  }

  py::dict grains(std::size_t point) const { return grains_of(snapshot(point)); }
  py::dict contacts(std::size_t point) const { return contacts_of(*snapshot(point)); }
  std::vector<std::vector<double>> cell(std::size_t point) const {
    const auto s = snapshot(point);
    std::vector<std::vector<double>> rows(3, std::vector<double>(3));
    for (int i = 0; i < 9; ++i)
      rows[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)] = s->boundary.cell.vectors(i / 3, i % 3);
    return rows;
  }

  py::bytes bytes(std::size_t point) const {
    const Use use(busy_);
    return set_.bytes(point);
  }
  void restore(std::size_t point, const py::bytes& state) {
    const Use use(busy_);
    set_.restore(point, state);
  }
  std::vector<py::bytes> parts() const {
    const Use use(busy_);
    std::vector<py::bytes> parts;
    set_.save([&](const std::string& part) { parts.emplace_back(part); });
    return parts;
  }
  void load(const std::vector<std::string>& parts) {
    const Use use(busy_);
    set_.load(parts);
  }
  std::size_t size() const { return set_.size(); }
  std::size_t distinct() const { return set_.distinct(); }

private:
  /// Two Python threads in one set would be a race: the second is told.
  class Use {
  public:
    explicit Use(std::atomic<bool>& busy) : busy_(busy) {
      if (busy_.exchange(true)) throw std::runtime_error("this set is at work in another thread");
    }
    ~Use() { busy_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

  private:
    std::atomic<bool>& busy_;
  };

  static std::vector<dem::State> states(const std::vector<py::bytes>& prepared) {
    std::vector<dem::State> all;
    for (const auto& bytes : prepared) all.push_back(dem::state_of(std::string(bytes)));
    return all;
  }
  std::shared_ptr<const dem::State> snapshot(std::size_t point) const {
    const Use use(busy_);
    return std::make_shared<const dem::State>(set_.state(point));
  }

  dem::RveOptions options_;
  dem::RveSet set_;
  mutable std::atomic<bool> busy_{false};
};

void write_parts(const std::string& path, const std::string& about, const py::iterable& parts) {
  dem::write_checkpoint(path, about, [&](const dem::TakePart& take) {
    for (const auto& part : parts) take(part.cast<std::string>());
  });
}

py::tuple read_parts(const std::string& path) {
  const dem::Checkpoint kept = dem::read_checkpoint(path);
  std::vector<py::bytes> parts(kept.parts.begin(), kept.parts.end());
  return py::make_tuple(kept.about, parts);
}

/// Errors are those of grus/errors.py: what reads results raises them without this module.
void raise_as_python(const py::module_& errors) {
  static const py::handle input_error = py::object(errors.attr("InputError")).release();
  static const py::handle unstable = py::object(errors.attr("Unstable")).release();
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const dem::InputError& e) {
      PyErr_SetString(input_error.ptr(), e.what());
    } catch (const dem::Unstable& e) {
      PyErr_SetString(unstable.ptr(), e.what());
    }
  });
}

}  // namespace
}  // namespace grus::python

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  using namespace grus::python;
  raise_as_python(py::module_::import("grus.errors"));
  m.def("usable_cores", &grus::app::usable_cores);
  m.def("write_parts", &write_parts);
  m.def("read_parts", &read_parts);
  m.def("grains_of", [](const std::string& state) {
    return grains_of(std::make_shared<const grus::dem::State>(grus::dem::state_of(state)));
  });
  m.def("hash_of", [](const std::string& state) { return grus::dem::hash(grus::dem::state_of(state)); });
  m.def("contacts_of", [](const std::string& state) { return contacts_of(grus::dem::state_of(state)); });
  py::class_<UnitCells>(m, "Cells")
      .def(py::init<const std::string&, const std::vector<std::string>&, int>())
      .def(py::init<const py::dict&, const std::string&, int>())
      .def("prepare", &UnitCells::prepare)
      .def_property_readonly("record", &UnitCells::record)
      .def_property_readonly("notes", &UnitCells::notes)
      .def_property_readonly("materials", &UnitCells::materials)
      .def_property_readonly("kin", &UnitCells::kin);
  py::class_<Set>(m, "Set")
      .def(py::init<const UnitCells&, const std::vector<py::bytes>&, const std::vector<std::size_t>&,
                    const std::string&, int>())
      .def("advance", &Set::advance)
      .def("commit", &Set::commit)
      .def("facts", &Set::facts)
      .def("report", &Set::report)
      .def("grains", &Set::grains)
      .def("contacts", &Set::contacts)
      .def("cell", &Set::cell)
      .def("bytes", &Set::bytes)
      .def("restore", &Set::restore)
      .def("parts", &Set::parts)
      .def("load", &Set::load)
      .def("__len__", &Set::size)
      .def_property_readonly("distinct", &Set::distinct);
}
