// SPDX-License-Identifier: LGPL-3.0-or-later
// Where each kind of macro run stands, as JSON with exact numbers, for checkpoints; and back. Every member is there, by
// what the structs declare.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "dem/base/error.hpp"
#include "dem/base/members.hpp"
#include "fem/statics.hpp"

namespace grus::app {

/// Where a run goes on from after an increment.
inline fem::StaticsStart start_after(const fem::IncrementReport& r) {
  return {.load_factor = r.load_factor,
          .next_size = r.next_size,
          .increments = r.increment,
          .law_sweeps = r.law_sweeps,
          .largest_force = r.largest_force,
          .stiffest = r.stiffest,
          .last_size = r.last_size,
          .energy = r.energy};
}

/// Numbers, and structs and arrays of such: lists of their members in order.
template <class T>
nlohmann::json save(const T& v) {
  if constexpr (std::is_floating_point_v<T>) {
    return fmt::format("{:a}", v);  // exact
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    return v;
  } else {
    nlohmann::json all = nlohmann::json::array();
    const auto add = [&](const auto& member) { all.push_back(save(member)); };
    if constexpr (requires { v.begin(); })
      for (const auto& each : v) add(each);
    else
      for_each_member(v, add);
    return all;
  }
}

/// Throws InputError for a number that is not finite, nlohmann::json::exception for what `save` cannot have made.
template <class T>
void load(const nlohmann::json& at, T& v) {
  if constexpr (std::is_floating_point_v<T>) {
    v = std::strtod(at.get<std::string>().c_str(), nullptr);
    if (!std::isfinite(v)) throw dem::InputError("checkpoint.h5: checkpoint is damaged: where the run stands");
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    v = at.get<T>();
  } else {
    std::size_t k = 0;
    const auto next = [&](auto& member) { load(at.at(k++), member); };
    if constexpr (requires { v.begin(); })
      for (auto& each : v) next(each);
    else
      for_each_member(v, next);
    if (k != at.size()) throw dem::InputError("checkpoint.h5: checkpoint is damaged: where the run stands");
  }
}

}  // namespace grus::app
