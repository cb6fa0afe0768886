// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/breakage.hpp"

#include <array>
#include <atomic>
#include <numeric>

#include "dem/bond/cohesive.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/rve/bonding.hpp"
#include "dem/rve/split_statistics.hpp"

namespace grus::dem {
namespace {

/// Calls f(contact, is b, tension) for the touching contacts of grain i.
template <class F>
void each_tension(const Model& model, const State& state, std::size_t i, F&& f) {
  const Contacts& contacts = state.contacts;
  const double nu = model.materials[state.grains.material[i]].poissons_ratio;
  for (Index e = contacts.first[i]; e < contacts.first[i + 1]; ++e) {
    const std::size_t k = contacts.entry[e] >> 1;
    const Contact c = contacts.contact[k];
    if (c.stiffness <= 0) continue;
    f(k, contacts.entry[e] & 1,
      ContactTension::tension(elastic_force(model.law, contacts, k), std::sqrt(c.radius * contacts.touch[k].overlap),
                              nu));
  }
}

struct Critical {
  double tension;  // Pa
  Vec3 arm;        // from the centre of mass (m)
};

/// Normal (global) of the plane of the three contacts of largest tension that are not in line, among those of at least
/// `strength`; none if fewer than `count` reach it.
std::optional<Vec3> contact_plane(const Model& model, const State& state, std::size_t i, double strength, int count) {
  std::vector<Critical> critical;
  each_tension(model, state, i, [&](std::size_t k, bool is_b, double tension) {
    if (tension >= strength) critical.push_back({tension, contact_arm(state.grains, state.contacts, k, is_b)});
  });
  if (critical.size() < static_cast<std::size_t>(std::max(count, 3))) return std::nullopt;
  std::stable_sort(critical.begin(), critical.end(),
                   [](const auto& a, const auto& b) { return a.tension > b.tension; });
  const Vec3 &p = critical[0].arm, &q = critical[1].arm;
  for (std::size_t k = 2; k < critical.size(); ++k) {
    const Vec3 u = q - p, v = critical[k].arm - p, n = u.cross(v);
    if (n.norm() > 1e-3 * u.norm() * v.norm()) return n.normalized();
  }
  return std::nullopt;
}

/// The tension that the asked number of contacts reach, over the strength; 0 where there are fewer.
double tension_utilisation(const Model& model, const State& state, std::size_t i, const ContactTension& criterion,
                           double factor) {
  std::array<double, most_critical_contacts> largest;
  const auto count = static_cast<std::size_t>(criterion.critical_contacts);
  std::size_t found = 0;
  each_tension(model, state, i, [&](std::size_t, bool, double tension) {
    std::size_t to = std::min(found, count);
    for (; to > 0 && largest[to - 1] < tension; --to)
      if (to < count) largest[to] = largest[to - 1];
    if (to < count) largest[to] = tension, found = std::min(found + 1, count);
  });
  return found < count ? 0 : largest[count - 1] / (criterion.strength * factor);
}

/// How near grain i is to failing, 1: it fails; 0 where it may not break.
struct Loading {
  double hoek_brown = 0, tension = 0;
  double utilisation() const { return std::max(hoek_brown, tension); }
};

Loading loading_of(const Model& model, const State& state, std::size_t i) {
  const Grains& g = state.grains;
  const auto& fracture = model.materials[g.material[i]].fracture;
  Loading found;
  if (!fracture || g.generation[i] >= fracture->max_generations) return found;
  if (fracture->smallest_radius > 0 && g.extent[i].equivalent_radius < fracture->smallest_radius) return found;
  if (!choose_axis(g.shape[i], Vec3::Zero())) return found;
  if (fracture->hoek_brown)
    found.hoek_brown = fracture->hoek_brown->utilisation(grain_stress(g, state.contacts, i), g.strength[i]);
  if (found.hoek_brown >= 1 || !fracture->contact_tension) return found;
  const ContactTension& criterion = *fracture->contact_tension;
  found.tension = tension_utilisation(model, state, i, criterion, g.strength[i]);
  if (found.tension >= 1 &&
      !contact_plane(model, state, i, criterion.strength * g.strength[i], criterion.critical_contacts))
    found.tension = 0;  // in line
  return found;
}

/// Along which plane a grain that fails breaks.
Break break_of(const Model& model, const State& state, std::size_t i) {
  const Grains& g = state.grains;
  const FractureModel& fracture = *model.materials[g.material[i]].fracture;
  const bool by_stress = loading_of(model, state, i).hoek_brown >= 1;
  std::optional<Vec3> plane;
  if (by_stress ? fracture.plane == BreakPlane::critical_contacts : fracture.plane != BreakPlane::average_stress) {
    const double strength = by_stress ? 0 : fracture.contact_tension->strength * g.strength[i];
    plane = contact_plane(model, state, i, strength, by_stress ? 3 : fracture.contact_tension->critical_contacts);
  }
  const Mat3 stress = grain_stress(g, state.contacts, i), axes = g.orientation[i].toRotationMatrix();
  const AxisPreference preference = plane ? AxisPreference((axes.transpose() * *plane).cwiseAbs())
                                          : AxisPreference((axes.transpose() * stress * axes).diagonal());
  Break b{i, *choose_axis(g.shape[i], preference), std::nullopt};
  if (is_sphere(g, i) &&
      (fracture.turn_spheres || fracture.slight_rotation > 0)) {  // only a sphere's axes are free to turn
    Quat q = g.orientation[i];
    if (fracture.turn_spheres) {
      Eigen::SelfAdjointEigenSolver<Mat3> principal;
      if (!plane) principal.computeDirect(stress);
      q = turned_to_plane(q, b.axis, plane ? *plane : Vec3(principal.eigenvectors().col(2)));
    }
    if (fracture.slight_rotation > 0)
      q = (q * Quat(slight_rotation(fracture.slight_rotation, model.seed, g.id[i]))).normalized();
    b.orientation = q;
  }
  return b;
}

/// A neighbour at the plane may touch both halves: together they go on with no more than the parent's force. The
/// contacts that both inherited share their stiffness in proportion to what the deeper one carries. Says whether there
/// are any.
bool share_contacts(const Model& model, State& state, std::size_t plus, std::size_t minus) {
  bool shared = false;
  Contacts& contacts = state.contacts;
  auto touching = [&](std::size_t k) { return contacts.contact.touching(k); };
  auto other = [&](Index e) {
    return contacts.entry[e] & 1 ? contacts.pair[contacts.entry[e] >> 1].a : contacts.pair[contacts.entry[e] >> 1].b;
  };
  auto image = [&](Index e) {  // of the other grain, as seen from this one
    std::array<int, 3> v;
    for (std::size_t n = 0; n < 3; ++n)
      v[n] = (contacts.entry[e] & 1 ? -1 : 1) * contacts.pair[contacts.entry[e] >> 1].image[n];
    return v;
  };
  for (Index e = contacts.first[plus]; e < contacts.first[plus + 1]; ++e) {
    const std::size_t k = contacts.entry[e] >> 1;
    const bool wall = k >= contacts.begin[first_wall];
    if (!touching(k) || (!wall && other(e) == minus)) continue;
    for (Index f = contacts.first[minus]; f < contacts.first[minus + 1]; ++f) {
      const std::size_t l = contacts.entry[f] >> 1;
      if (!touching(l) || (l >= contacts.begin[first_wall]) != wall || other(f) != other(e) || image(f) != image(e))
        continue;
      Contact a = contacts.contact[k], b = contacts.contact[l];
      if (a.stiffness != b.stiffness) continue;  // not both inherited
      const double fa = elastic_force(model.law, contacts, k), fb = elastic_force(model.law, contacts, l);
      const double share = std::max(fa, fb) / (fa + fb);
      for (Contact* c : {&a, &b}) c->stiffness *= share, c->spring *= share, c->compliance /= share;
      contacts.contact.set(k, a), contacts.contact.set(l, b);
      shared = true;
      break;
    }
  }
  return shared;
}

/// Elastic energy of the contacts of some grains; a contact between two of them counts once (J).
double energy_of(const Model& model, const State& state, const std::vector<Index>& grains) {
  std::vector<std::uint8_t> among(state.grains.size(), 0);
  for (const Index i : grains) among[i] = 1;
  const Contacts& c = state.contacts;
  double sum = 0;
  for (const Index i : grains)
    for (Index e = c.first[i]; e < c.first[i + 1]; ++e) {
      const std::size_t k = c.entry[e] >> 1;
      const bool twice = k < c.begin[first_wall] && among[c.pair[k].a] && among[c.pair[k].b];
      const auto held = [&](const auto& law) { return elastic_energy(law, c.contact[k], c.touch[k].overlap); };
      sum += (twice ? 0.5 : 1) * std::visit(held, model.law);
    }
  return sum;
}

void refresh_forces(const Model& model, State& state, Team& team) {
  contact_forces(model.law, model.pairs, state.grains, state.boundary, 0, true, state.contacts, team);
  flush(state.contacts);  // what the lost contacts held is booked by the caller's balance
  if (!state.bonds.empty()) bond_forces(state.grains, state.bonds, state.ledger);
  std::vector<SweepEnergy> none;
  sweep(Kick::close, state.grains, state.contacts, model.motion, !state.bonds.empty(), 0, none, team);
}

}  // namespace

void draw_strength(const Model& model, Grains& g, std::size_t i) {
  const auto& fracture = model.materials[g.material[i]].fracture;
  g.strength[i] = fracture ? fracture->strength_factor(g.extent[i].equivalent_radius, model.seed, g.id[i]) : 1;
}

std::vector<Break> find_breaks(const Model& model, State& state, Team& team) {
  enum : std::uint8_t { holds, bonded, fails };
  Grains& g = state.grains;
  auto& room = state.break_room;
  room.assign(g.size(), holds);
  for (const auto& s : state.bonds) room[s.a] = room[s.b] = bonded;
  const double since = static_cast<double>(state.steps - state.tested_at), every = model.numerics.fracture_every;
  std::atomic<std::uint64_t> soonest{static_cast<std::uint64_t>(every) -
                                     state.steps % static_cast<std::uint64_t>(every)};
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    double steps = every;
    for (std::size_t i = begin; i < end; ++i) {
      if (room[i] == bonded) continue;
      const double now = loading_of(model, state, i).utilisation(), rate = (now - g.utilisation[i]) / since;
      if (now >= 1)
        room[i] = fails;
      else if (now + rate * every > 1 + overshoot)
        steps = std::min(steps, (1 + overshoot - now) / rate);
      g.utilisation[i] = now;
    }
    const auto mine = static_cast<std::uint64_t>(std::max(1.0, std::floor(steps)));
    for (std::uint64_t least = soonest; mine < least && !soonest.compare_exchange_weak(least, mine);) {
    }
  });
  state.tested_at = state.steps, state.next_test = state.steps + soonest;
  std::vector<Break> breaks;
  for (std::size_t i = 0; i < room.size(); ++i)
    if (room[i] == fails) breaks.push_back(break_of(model, state, i));
  return breaks;
}

void apply_breaks(const Model& model, State& state, const std::vector<Break>& breaks, Team& team) {
  Grains& g = state.grains;
  Ledger& ledger = state.ledger;
  // Contacts slide by the dashpots of the whole step's velocities; that is friction, and must not be taken for what the
  // split does.
  contact_forces(model.law, model.pairs, g, state.boundary, 0, true, state.contacts, team);
  drop_loads(state.contacts);
  book(flush(state.contacts), ledger);
  const double elastic_before = elastic_energy(model.law, state.contacts);
  const double bonds_before = stored_energy(state.bonds), fracture_before = ledger.fracture;
  const std::size_t grains_before = g.size(), springs_before = state.bonds.size();
  std::vector<Index> few;
  for (const auto& b : breaks) few.push_back(static_cast<Index>(b.grain));
  double left = energy_of(model, state, few);
  ParentContacts before;
  if (model.split_statistics) {
    std::vector<std::size_t> parents;
    for (const auto& b : breaks) parents.push_back(b.grain);
    before = contacts_of(model, state, parents);
  }
  std::vector<Index> origin(g.size() + breaks.size());
  std::iota(origin.begin(), origin.begin() + static_cast<std::ptrdiff_t>(g.size()), 0u);
  std::vector<ParentMotion> parents;
  std::vector<std::size_t> minus;
  for (const auto& b : breaks) {
    if (b.orientation) g.orientation[b.grain] = *b.orientation;
    parents.push_back(motion_of(g, b.grain));
    minus.push_back(g.size());
    origin[g.size()] = static_cast<Index>(b.grain);
    split_grain(g, b.grain, b.axis, *model.materials[g.material[b.grain]].fracture, ledger.fines);
    draw_strength(model, g, b.grain);
    draw_strength(model, g, minus.back());
    g.utilisation[b.grain] = g.utilisation[minus.back()] = NAN;
  }
  update_frames(g);
  for (const std::size_t i : minus) few.push_back(static_cast<Index>(i));
  mend_contacts(g, state.boundary, state.skin, model.materials.size(), few, origin, state.contacts, state.reference,
                team);
  refresh_forces(model, state, team);
  bool shared = false;
  for (std::size_t k = 0; k < breaks.size(); ++k)
    shared = share_contacts(model, state, breaks[k].grain, minus[k]) || shared;
  if (shared) refresh_forces(model, state, team);
  if (model.split_statistics) {
    std::vector<std::array<std::size_t, 2>> halves;
    for (std::size_t k = 0; k < breaks.size(); ++k) halves.push_back({breaks[k].grain, minus[k]});
    count_split(model, state, before, halves, origin, grains_before);
  }
  for (std::size_t k = 0; k < breaks.size(); ++k)
    if (model.materials[g.material[breaks[k].grain]].fracture->springs)
      add_springs(model, state, parents[k], breaks[k].axis, breaks[k].grain, minus[k]);
  for (std::size_t k = springs_before; k < state.bonds.size(); ++k)
    left -= 0.5 * state.bonds[k].peak / state.bonds[k].onset * state.bonds[k].preload.squaredNorm();
  add_bond_forces(g, state.bonds, springs_before, ledger);
  ledger.breakages += breaks.size();
  left -= energy_of(model, state, few);
  const double gone = elastic_before + bonds_before - elastic_energy(model.law, state.contacts) -
                      stored_energy(state.bonds) - (ledger.fracture - fracture_before);
  ledger.split += left, ledger.unexplained += gone - left;
  ledger.split_added += std::max(0.0, -left);
}

}  // namespace grus::dem
