// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/hand_over.hpp"

#include <algorithm>
#include <numeric>

#include "dem/bond/face_bond.hpp"
#include "dem/contact/hull_pairs.hpp"

namespace grus::dem {
namespace {

/// The lower grain first; true: they changed places.
bool put_in_order(Pair& p) {
  if (p.a <= p.b) return false;
  std::swap(p.a, p.b);
  for (auto& v : p.image) v = static_cast<std::int16_t>(-v);
  return true;
}

/// What the contact after a bond will hold, and what of the bond's is then nobody's.
void book_kept(State& state, Handed& h) {
  const Grains& g = state.grains;
  const Pair p{h.ends.a, h.ends.b, h.ends.image};
  const Vec3 apart = branch(g, state.boundary.cell, h.ends);
  const Overlap o = overlap_of_pair(g, state.boundary.cell, p, apart.normalized());
  const double shear = o.volume > 0 ? 0.5 * h.compliance * h.shear.squaredNorm() : 0;
  h.kept = h.modulus * o.energy + shear;
  const double lost = h.held - h.kept;  // below 0: made, and so missing in the balance
  (lost > 0 ? state.ledger.handed : state.ledger.unexplained) += lost;
}

bool goes_on(const Handed& h) { return h.modulus > 0; }

}  // namespace

void book_broken(State& state, bool recorded) {
  const Grains& g = state.grains;
  for (Handed& h : state.bonds.handed) {
    if (goes_on(h)) book_kept(state, h);
    state.ledger.fracture_area += h.fresh;
    if (!recorded) continue;
    const Vec3 at = g.motion[h.ends.a].position + g.orientation[h.ends.a] * h.at_a;
    state.bonds.broken.push_back({state.time, at, h.area, h.spent, g.id[h.ends.a], g.id[h.ends.b],
                                  g.orientation[h.ends.a] * h.normal, h.sliding});
  }
  std::erase_if(state.bonds.handed, [](const Handed& h) { return !goes_on(h); });
}

void note_bonded(State& state) {
  std::vector<Pair>& bonded = state.reference.bonded;
  bonded.clear();
  for (const FaceBond& b : state.bonds.face.row) {
    if (b.criterion == FaceCriterion::rod) continue;
    Pair p{b.ends.a, b.ends.b, b.ends.image};
    put_in_order(p);
    bonded.push_back(p);
  }
  std::sort(bonded.begin(), bonded.end(), by_place);
  std::vector<Pair>& walled = state.reference.walled;
  walled.clear();
  for (const FaceBond& b : state.bonds.wall) walled.push_back({b.ends.a, b.ends.b});
  std::sort(walled.begin(), walled.end(), by_place);
}

void take_over(State& state) {
  if (state.bonds.handed.empty()) return;
  Contacts& c = state.contacts;
  std::vector<std::pair<Pair, std::size_t>> listed;
  for (std::size_t k = c.begin[hull_hull]; k < c.begin[hull_hull + 1]; ++k)
    listed.push_back({{c.pair[k].a, c.pair[k].b, c.pair[k].image}, k});
  const auto before = [](const auto& x, const auto& y) { return by_place(x.first, y.first); };
  std::sort(listed.begin(), listed.end(), before);
  for (const Handed& h : state.bonds.handed) {
    Pair p{h.ends.a, h.ends.b, h.ends.image};
    const bool turned = put_in_order(p);
    const auto at = std::lower_bound(listed.begin(), listed.end(), std::pair{p, std::size_t{0}}, before);
    if (at == listed.end() || by_place(p, at->first)) continue;  // too far apart to be listed
    Contact contact;
    contact.radius = h.modulus, contact.stiffness = h.modulus * h.area;
    contact.spring[slide_spring] = turned ? Vec3(-h.shear) : h.shear, contact.compliance = h.compliance;
    c.contact.set(at->second, contact);
  }
  state.bonds.handed.clear();
}

Fragments fragments_of(const State& state) {
  Fragments f;
  f.of.resize(state.grains.size());
  std::iota(f.of.begin(), f.of.end(), Index{0});
  const auto root = [&](Index i) {
    while (f.of[i] != i) i = f.of[i] = f.of[f.of[i]];
    return i;
  };
  for (const FaceBond& b : state.bonds.face.row) {
    const Index a = root(b.ends.a), c = root(b.ends.b);
    f.of[std::max(a, c)] = std::min(a, c);
  }
  std::vector<std::size_t> count(f.of.size(), 0);
  for (Index i = 0; i < f.of.size(); ++i) ++count[f.of[i] = root(i)];
  std::vector<Index> order;
  for (Index i = 0; i < f.of.size(); ++i)
    if (count[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return count[a] > count[b]; });
  std::vector<Index> rank(f.of.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    rank[order[k]] = static_cast<Index>(k), f.size.push_back(count[order[k]]);
  for (Index& i : f.of) i = rank[i];
  return f;
}

}  // namespace grus::dem
