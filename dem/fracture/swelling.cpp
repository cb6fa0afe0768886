// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/swelling.hpp"

#include <algorithm>

#include "dem/fracture/apollonian.hpp"

namespace grus::dem {

std::optional<double> next_radius(const Grains& g, std::size_t i, double density, double stiffness, double duration) {
  const double now = g.extent[i].equivalent_radius;
  const double whole = std::cbrt(0.75 / pi * solid_mass(g, i) / density);
  if (now >= whole * (1 - 1e-12)) return std::nullopt;
  const double contact_time = pi * std::sqrt(g.mass[i] / stiffness);
  const double part = (1 - std::cbrt(kept_volume())) * duration / (swelling_times * contact_time);
  return std::min(whole, now + whole * std::min(part, swelling_step));
}

double mean_pressure(const ContactLaw& law, const Grains& g, const Contacts& contacts, std::size_t i) {
  double force = 0;
  for (Index e = contacts.index.first[i]; e < contacts.index.first[i + 1]; ++e) {
    const std::size_t k = contacts.index.entry[e] >> 1;
    if (contacts.contact.touching(k)) force += elastic_force(law, contacts, k);
  }
  return force * g.extent[i].equivalent_radius / (3 * g.extent[i].volume);
}

double mean_pressure(const ContactLaw& law, const Grains& g, const Contacts& contacts) {
  double moment = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!contacts.contact.touching(k)) continue;
    double arms = g.extent[contacts.pair[k].a].equivalent_radius;
    if (k < contacts.begin[first_wall]) arms += g.extent[contacts.pair[k].b].equivalent_radius;
    moment += elastic_force(law, contacts, k) * arms;
  }
  return moment / (3 * solid_volume(g));
}

}  // namespace grus::dem
