// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/unit_cells.hpp"

#include <fmt/format.h>

#include <map>

#include "apps/scene/open_rves.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/reader.hpp"
#include "dem/base/checksum.hpp"

namespace grus::app {

std::vector<RveScene> read_unit_cells(const std::string& file, std::vector<std::string> overrides, int variants) {
  std::vector<RveScene> cells{read_unit_cell(file, overrides)};
  const std::uint64_t seed = cells[0].model.seed;
  overrides.emplace_back();
  for (std::uint64_t v = 1; v < static_cast<std::uint64_t>(variants); ++v) {
    overrides.back() = fmt::format("packing.seed={}", seed + v);
    cells.push_back(read_unit_cell(file, overrides));
  }
  return cells;
}

dem::RveOptions read_rve_options(Table& t) {
  dem::RveOptions options;
  dem::ResponseOptions& response = options.response;
  response.quasi_static = read_quasi_static(t);
  using Kind = dem::TangentKind;
  const std::map<std::string, Kind> kinds{
      {"automatic", Kind::automatic}, {"contact-stiffness", Kind::contact_stiffness},
      {"network", Kind::network},     {"perturbation", Kind::perturbation},
      {"elastic", Kind::elastic},     {"quasi-newton", Kind::quasi_newton}};
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) names.push_back(name);
  response.tangent = kinds.at(t.choice_or("tangent", "automatic", names));
  if (response.tangent == Kind::perturbation) {
    response.perturbation = t.number_or("perturbation", response.perturbation, dimension::none, {1e-8, 0.01});
    response.central = t.flag_or("perturbation_central", false);
  }
  options.exact_sharing = t.flag_or("exact_sharing", true);
  if (auto a = t.table_if("adaptivity")) {
    options.share = a->number_or("share", 0, dimension::none, {0, 0.1});
    options.error = a->number_or("error", 0, dimension::none, {0, 0.5});
    if (a->has("elastic")) response.elastic = a->number("elastic", dimension::none, {0, 0.5});
    if (options.share > 0 && !options.exact_sharing) a->fail("share", "needs exact_sharing");
    a->finish();
  }
  return options;
}

void default_floor(dem::ResponseOptions& response, const RveScene& cell) {
  if (response.quasi_static.pressure_floor == 0 && cell.recipe.preparation)
    response.quasi_static.pressure_floor = 0.5 * cell.recipe.preparation->pressure;
}

dem::RveOptions options_of_text(const std::string& text, const std::string& place, const RveScene& cell) {
  toml::table parsed;
  try {
    parsed = toml::parse(text);
  } catch (const toml::parse_error& e) {
    throw InputError(fmt::format("{}: {}", place, e.description()));
  }
  nlohmann::json record;
  Table t(parsed, place, "rve", record);  // what [rve] of a problem may say
  dem::RveOptions options = read_rve_options(t);
  t.finish();
  using Kind = dem::TangentKind;
  if (options.response.tangent == Kind::elastic || options.response.tangent == Kind::quasi_newton)
    throw InputError(
        fmt::format("{}: tangent: \"elastic\" and \"quasi-newton\" are kept by the solver, not by the "
                    "RVEs: keep what the first advance returns",
                    place));
  default_floor(options.response, cell);
  return options;
}

std::uint64_t kin_of(const RveScene& cell) {
  nlohmann::json scene = *cell.record;
  if (scene.contains("packing")) scene["packing"].erase("seed");
  return dem::checksum(scene.dump());
}

dem::RveSet open_rves(const std::string& file, const std::vector<std::string>& overrides, std::size_t points,
                      int threads, const std::string& response) {
  const RveScene cell = read_unit_cell(file, overrides);
  const dem::RveOptions options = options_of_text(response, "response", cell);
  dem::Team alone(1);
  const dem::State prepared = prepare_sample(cell, alone);
  const std::vector<std::size_t> start(points, 0);
  return {std::make_shared<dem::Model>(cell.model), {prepared}, start, options, threads, kin_of(cell)};
}

}  // namespace grus::app
